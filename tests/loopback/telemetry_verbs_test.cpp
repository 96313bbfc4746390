// SPDX-License-Identifier: BSD-3-Clause
// `casctl watch` and `casctl message` through the real casd, beside the emulated controller.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/loopback/emulator_fixture.hpp"
#include "tests/support/ended_with.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells{""};
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

/// On the ground without a simulator: it sends attitude and battery, but no position.
class TelemetryVerbs : public testing::Test {
 protected:
  void SetUp() override {
    fixture.start();
    ASSERT_TRUE(fixture.hears_the_vehicle()) << fixture.output();
    ASSERT_TRUE(wait_until([this] {
      const Ended said = fixture.casctl({"watch", "attitude", "battery", "--json", "--count", "1"});
      if (said.code != 0) return false;
      const json sample = json::parse(said.output);
      return sample.at("attitude").at("roll_deg").is_number() &&
             sample.at("battery").at("voltage_v").is_number();
    })) << fixture.output();
  }
  /// Runs casctl with a --timeout that is soon over.
  Ended impatient(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {cas::test::binary_dir() + "/bin/casctl", "--address",
                                         "unix:" + fixture.socket(), "--timeout", "0.3"});
    return ChildProcess(arguments).end(std::chrono::seconds(60));
  }

  EmulatorFixture fixture;
};

TEST_F(TelemetryVerbs, WatchPrintsAnObjectALineWithNullForWhatIsNotKnown) {
  const Ended said =
      fixture.casctl({"watch", "attitude", "position", "battery", "--json", "--count", "3"});
  EXPECT_EQ(said.code, 0) << said.output;
  const std::vector<std::string> lines = lines_of(said.output);
  ASSERT_EQ(lines.size(), 3U) << said.output;
  double last_s = -1;
  for (const std::string& line : lines) {
    const json sample = json::parse(line);
    EXPECT_EQ(sample.size(), 6U) << line;  // two times, the vehicle and three topics
    EXPECT_EQ(sample.at("vehicle"), 1);
    EXPECT_GT(sample.at("time_s"), last_s);
    last_s = sample.at("time_s");
    EXPECT_TRUE(sample.at("attitude").at("roll_deg").is_number());
    EXPECT_GE(sample.at("attitude").at("age_s"), 0.0);
    EXPECT_TRUE(sample.at("position").at("north_m").is_null());
    EXPECT_TRUE(sample.at("position").at("age_s").is_null());
    EXPECT_NEAR(sample.at("battery").at("voltage_v").get<double>(), 16.2, 1.0);
  }
}

TEST_F(TelemetryVerbs, WatchPrintsATableForOtherPrograms) {
  const Ended said = fixture.casctl({"watch", "attitude", "gps", "--csv", "--count", "2"});
  EXPECT_EQ(said.code, 0) << said.output;
  const std::vector<std::string> lines = lines_of(said.output);
  ASSERT_EQ(lines.size(), 3U) << said.output;
  const std::vector<std::string> header = cells_of(lines[0]);
  EXPECT_EQ(header[3], "attitude_roll_deg");
  EXPECT_EQ(header.back(), "gps_age_s");
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> cells = cells_of(lines[i]);
    ASSERT_EQ(cells.size(), header.size()) << lines[i];
    EXPECT_EQ(cells[2], "1");
    EXPECT_NE(cells[3], "");
    EXPECT_EQ(cells.back(), "");  // no GPS without a simulator
  }
}

TEST_F(TelemetryVerbs, WatchEndsAfterItsTimeAndNamesUnits) {
  const Ended said = fixture.casctl({"watch", "--rate", "10", "--for", "0.35"});
  EXPECT_THAT(said, EndedWith(0, "roll 0.00 deg", "position  not heard yet", " V, current "));
  EXPECT_LE(lines_of(said.output).size(), 4U * 6U)
      << said.output;  // at 0, 0.1, 0.2, 0.3 s; six topics
}

TEST_F(TelemetryVerbs, WatchKnowsItsTopics) {
  EXPECT_THAT(fixture.casctl({"watch", "atitude"}), EndedWith(2, "did you mean 'attitude'?"));
  EXPECT_EQ(fixture.casctl({"watch", "--csv", "--json"}).code, 2);
}

TEST_F(TelemetryVerbs, StatusHasTheSameTelemetry) {
  const Ended said = fixture.casctl({"status", "--json"});
  ASSERT_EQ(said.code, 0) << said.output;
  const json telemetry = json::parse(said.output).at("vehicles").at(0).at("telemetry");
  EXPECT_TRUE(telemetry.at("battery").at("voltage_v").is_number()) << telemetry;
  EXPECT_TRUE(telemetry.at("gps").at("fix").is_null()) << telemetry;
  EXPECT_EQ(telemetry.size(), 10U) << telemetry;
}

TEST_F(TelemetryVerbs, MessageShowsAllFieldsOfTheNewest) {
  EXPECT_THAT(fixture.casctl({"message", "attitude"}),
              EndedWith(0, "ATTITUDE (30) from 1/1 on link fcu", "yawspeed"));
  const Ended said = fixture.casctl({"message", "ATTITUDE", "--json", "--system", "1"});
  ASSERT_EQ(said.code, 0) << said.output;
  const json message = json::parse(said.output);
  EXPECT_EQ(message.at("fields").size(), 7U) << message;
  EXPECT_EQ(message.at("units").at("roll"), "rad");
}

/// Bash's completion of the last of these words.
std::string offered(const EmulatorFixture& fixture, const std::string& words, int position) {
  const auto script = fixture.folder.write(
      "complete.bash", "PATH='" + cas::test::binary_dir() + "/bin':$PATH\n" +
                           "export CASD_ADDRESS='unix:" + fixture.socket() +
                           "'\nsource <(casctl --manual bash)\nCOMP_WORDS=(" + words +
                           ")\nCOMP_CWORD=" + std::to_string(position) +
                           "\n_casctl_completion\necho \"${COMPREPLY[@]}\"\n");
  ChildProcess bash({"/bin/bash", script.string()});
  EXPECT_EQ(bash.wait_exit(std::chrono::seconds(60)), 0) << bash.output();
  return bash.output();
}

TEST_F(TelemetryVerbs, CompletionKnowsWhatTheVehicleHas) {
  EXPECT_EQ(offered(fixture, "casctl setgain rollr", 2), "rollrate\n");
  EXPECT_EQ(offered(fixture, "casctl mode POSC", 2), "POSCTL\n");
  EXPECT_EQ(offered(fixture, "casctl watch attitude batt", 3), "battery\n");
  EXPECT_EQ(offered(fixture, "casctl message SYS_ST", 2), "SYS_STATUS\n");
  EXPECT_EQ(offered(fixture, "casctl param get MC_ROLLRATE_P", 3), "MC_ROLLRATE_P\n");
}

TEST_F(TelemetryVerbs, CompletionLacksNoLoopAndNoModeOfTheVehicle) {
  const std::string modes = " " + offered(fixture, "casctl mode ''", 2);
  const std::string refusal = fixture.casctl({"mode", "NOPE"}).output;
  std::istringstream words(refusal.substr(refusal.find("it has ") + 7));
  int compared = 0;
  for (std::string word; words >> word; ++compared) {
    EXPECT_NE((modes + " ").find(" " + word), std::string::npos) << word << " in" << modes;
  }
  EXPECT_GT(compared, 10) << refusal;
  const std::string loops = " " + offered(fixture, "casctl gains ''", 2);
  const Ended gains = fixture.casctl({"gains", "--json"});
  ASSERT_EQ(gains.code, 0) << gains.output;
  for (const json& loop : json::parse(gains.output)) {
    const auto name = loop.at("loop").get<std::string>();
    EXPECT_NE(loops.find(" " + name), std::string::npos) << name << " in" << loops;
  }
}

// Sent once, on request, before the first look.
TEST_F(TelemetryVerbs, MessageShowsOneThatCameBeforeAnybodyLooked) {
  ASSERT_TRUE(wait_until([this] {
    return fixture.casctl({"monitor", "--once"}).output.find("AUTOPILOT_VERSION") !=
           std::string::npos;
  }));
  const Ended said = fixture.casctl({"message", "AUTOPILOT_VERSION", "--json"});
  ASSERT_EQ(said.code, 0) << said.output;
  EXPECT_EQ(json::parse(said.output).at("fields").at("uid"), 1);
}

TEST_F(TelemetryVerbs, MessageSaysInASentenceThatNoneCame) {
  EXPECT_THAT(fixture.casctl({"message", "GPS_RAW_INT"}),
              EndedWith(1, "no GPS_RAW_INT has come yet"));
  EXPECT_THAT(fixture.casctl({"message", "ATTITUDE", "--system", "9"}),
              EndedWith(1, "no ATTITUDE of system 9 has come yet"));
  EXPECT_THAT(fixture.casctl({"message", "ATTITUD"}), EndedWith(1, "did you mean 'ATTITUDE'?"));
  EXPECT_THAT(impatient({"message", "GPS_RAW_INT", "--wait"}), EndedWith(4));
}

}  // namespace
}  // namespace cas::test
