// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/verbs/telemetry.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace cas::casctl {
namespace {

TelemetrySample sample() {
  TelemetrySample sample;
  sample.time_s = 1.5;
  sample.unix_s = 1795387181.25;
  sample.answer = {
      {"vehicle", 3},
      {"state", {{"armed", true}, {"mode", "a \"b\", c"}, {"landed", "in_air"}, {"age_s", 0.25}}},
      {"attitude",
       {{"roll_deg", 0.126}, {"pitch_deg", nullptr}, {"yaw_deg", -90}, {"age_s", 12.34}}},
      {"rotors", {{"output1_us", 1500}, {"output2_us", nullptr}, {"age_s", 0}}},
      {"gps", {{"age_s", nullptr}}}};
  return sample;
}

TEST(TelemetryLines, CsvHasAColumnForEachValueAndNothingForWhatIsNotKnown) {
  const auto topics = chosen_topics({"attitude", "gps"});
  const std::string header = csv_header(topics);
  const std::string line = csv_line(sample(), topics);
  EXPECT_TRUE(header.starts_with(
      "time_s,unix_s,vehicle,attitude_roll_deg,attitude_pitch_deg,attitude_yaw_deg,"
      "attitude_age_s,gps_fix,"))
      << header;
  EXPECT_TRUE(line.starts_with("1.500,1795387181.250,3,0.126,,-90,12.34,,")) << line;
  EXPECT_EQ(std::count(header.begin(), header.end(), ','),
            std::count(line.begin(), line.end(), ','));
}

TEST(TelemetryLines, CsvQuotesTexts) {
  EXPECT_EQ(csv_line(sample(), chosen_topics({"state"})),
            "1.500,1795387181.250,3,true,\"a \"\"b\"\", c\",in_air,,0.25");
}

TEST(TelemetryLines, JsonKeepsTheOrderAndSaysNull) {
  EXPECT_EQ(json_line(sample(), chosen_topics({"attitude"})),
            R"({"time_s":1.5,"unix_s":1795387181.25,"vehicle":3,"attitude":{"roll_deg":0.126,)"
            R"("pitch_deg":null,"yaw_deg":-90,"age_s":12.34}})");
}

TEST(TelemetryLines, TextNamesUnitsAndTheAgeOfWhatIsOld) {
  EXPECT_EQ(text_lines(sample(), chosen_topics({"attitude", "gps", "rotors"})),
            "    1.50 s  attitude  roll 0.13 deg, pitch - deg, yaw -90.00 deg  (12.3 s old)\n"
            "    1.50 s  gps       not heard yet\n"
            "    1.50 s  rotors    output1 1500 us");
}

TEST(TelemetryLines, TopicsAreThoseNamedOnceEachOrTheUsualOnes) {
  EXPECT_EQ(chosen_topics({"gps", "attitude", "gps"}).size(), 2U);
  EXPECT_EQ(chosen_topics({"gps", "attitude"}).front().name, "gps");
  EXPECT_EQ(chosen_topics({}).size(), 6U);
  EXPECT_EQ(telemetry_topic_names().size(), 10U);
}

}  // namespace
}  // namespace cas::casctl
