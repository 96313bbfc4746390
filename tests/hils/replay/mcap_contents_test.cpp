// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/mcap_contents.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "tests/hils/mcap/mcap_bytes.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

using cas::test::McapBytes;
using OrderedJson = nlohmann::ordered_json;

constexpr std::uint64_t kSecondNs = 1'000'000'000;
/// Of a day in 2026, as recorders of a vehicle have it.
constexpr std::uint64_t kDayNs = 1'790'000'000 * kSecondNs;

std::vector<double> numbers(const OrderedJson& column) {
  std::vector<double> values;
  double sum = 0;
  for (const OrderedJson& difference : column.at("d")) {
    sum += difference.get<double>();
    values.push_back(sum * column.at("k").get<double>());
  }
  return values;
}

const OrderedJson& message_named(const OrderedJson& vehicle, const std::string& name) {
  for (const OrderedJson& message : vehicle.at("log").at("messages")) {
    if (message.at("name") == name) return message;
  }
  throw std::runtime_error("no message " + name);
}

TEST(McapContents, ShowsTheNumbersOfAnyJsonChannel) {
  const std::string file =
      McapBytes()
          .channel(1, 0, "/battery")
          .message(1, kDayNs, R"({"timestamp":{"sec":1},"cell":[3.5,4],"on":true,"who":"me"})")
          .message(1, kDayNs + kSecondNs, R"({"cell":[3.25],"on":false,"new":1})")
          .message(1, kDayNs + 2 * kSecondNs, "no JSON")
          .whole();
  McapLoss loss;
  const OrderedJson record = mcap_contents(file, "log_7", &loss);
  const OrderedJson& vehicle = record.at("vehicles").at(0);
  EXPECT_EQ(vehicle.at("name"), "log_7");
  EXPECT_TRUE(vehicle.at("truth").is_null());
  const OrderedJson& battery = message_named(vehicle, "/battery");
  EXPECT_EQ(numbers(battery.at("t")), (std::vector<double>{0, 1, 2}));
  ASSERT_EQ(battery.at("fields").size(), 3U);
  EXPECT_EQ(battery.at("fields").at(0).at("name"), "cell[0]");
  EXPECT_NEAR(numbers(battery.at("fields").at(0).at("values")).at(1), 3.25, 1e-9);
  EXPECT_EQ(battery.at("fields").at(2).at("name"), "on");
  EXPECT_EQ(record.at("duration_s"), 2);
  EXPECT_EQ(loss.sentence(), "1 message(s) that are no JSON object left out");
}

TEST(McapContents, TakesWhatStandsFromTheBeginForNoMoment) {
  const std::string file = McapBytes()
                               .channel(1, 0, "/static")
                               .channel(2, 0, "/a")
                               .message(1, 0, R"({"x":1})")
                               .message(2, kDayNs, R"({"x":1})")
                               .message(2, kDayNs + kSecondNs, R"({"x":1})")
                               .whole();
  EXPECT_EQ(mcap_contents(file, "a").at("duration_s"), 1);
}

TEST(McapContents, ReadsMavlinkAsATelemetryLogIsRead) {
  const std::string heartbeat =
      R"({"type":"MAV_TYPE_QUADROTOR","autopilot":"MAV_AUTOPILOT_PX4","base_mode":)"
      R"("MAV_MODE_FLAG_SAFETY_ARMED|MAV_MODE_FLAG_CUSTOM_MODE_ENABLED","custom_mode":50593792,)"
      R"("system_status":"MAV_STATE_ACTIVE","mavlink_version":3,"system":5,"component":1})";
  const std::string file =
      McapBytes()
          .channel(1, 0, "/mavlink/HEARTBEAT")
          .channel(2, 0, "/mavlink/ATTITUDE")
          .channel(3, 0, "/mavlink/LAB_MESSAGE")
          .message(1, 0, heartbeat)
          .message(2, 1000, R"({"roll":0.5,"pitch":null,"system":5,"component":1})")
          .message(2, 2000, R"({"roll":0.25,"system":255,"component":190})")
          .message(3, 3000, R"({"lab":7,"system":5,"component":1})")
          .whole();
  const OrderedJson record = mcap_contents(file, "a");
  const OrderedJson& vehicle = record.at("vehicles").at(0);
  EXPECT_EQ(vehicle.at("system"), 5);
  EXPECT_EQ(vehicle.at("log").at("states"), OrderedJson::parse(R"([[0.0,129,"HOLD",0]])"));
  const OrderedJson& attitude = message_named(vehicle, "ATTITUDE");
  EXPECT_EQ(attitude.at("rates"), OrderedJson::parse("[[0,1]]"));  // of system 5 alone
  EXPECT_NEAR(numbers(attitude.at("fields").at(0).at("values")).at(0), 0.5, 1e-4);
  EXPECT_EQ(message_named(vehicle, "/mavlink/LAB_MESSAGE").at("fields").at(0).at("name"), "lab");
}

TEST(McapContents, DrawsSceneTruthAndReferenceOfOurOwnFiles) {
  const std::string pose =
      R"("pose":{"position":{"x":1,"y":2,"z":3},"orientation":{"x":0,"y":0,"z":0,"w":1}})";
  const std::string file =
      McapBytes()
          .schema(1, "foxglove.SceneUpdate")
          .schema(2, "cas.Vehicle")
          .schema(3, "cas.Truth")
          .schema(4, "cas.Motors")
          .channel(1, 1, "/scene")
          .channel(2, 2, "/vehicle")
          .channel(3, 3, "/truth")
          .channel(4, 4, "/motors")
          .message(2, 0,
                   R"({"vehicle":"drone","model":"iris","system":3,"mass_kg":1.5,"rotors":[)"
                   R"({"p_B":[0.1,0.2,0],"axis_B":[0,0,1],"radius_m":0.1,"spin":1,"k_f":1e-5,)"
                   R"("omega_max_rad_s":1000},{"p_B":[0]}]})")
          .message(1, 0,
                   R"({"entities":[{"id":"world/wall","frame_id":"world","cubes":[{)" + pose +
                       R"(,"size":{"x":4,"y":5,"z":6}},{"size":{}}]},)" +
                       R"({"id":"drone","frame_id":"drone","triangles":[{)" + pose +
                       R"(,"points":[{"x":0,"y":0,"z":0},{"x":1,"y":0,"z":0},{"x":0,"y":1,"z":0}],)"
                       R"("indices":[0,1,2]},{)" +
                       pose + R"(,"points":[],"indices":[0,1,7]}]}]})")
          .message(4, 0, R"({"vehicle":"drone","speeds_rad_s":[400]})")
          .message(
              3, 0,
              R"({"vehicle":"drone","position":{"x":1,"y":2,"z":3},)"
              R"("velocity":{"x":0.5,"y":0.25,"z":0},)"
              R"("angular_velocity":{"x":0.125,"y":0.25,"z":0.5},"roll":0,"pitch":0.1,"yaw":1})")
          .message(3, kSecondNs, R"({"vehicle":"drone","position":{"x":"east"}})")
          .whole();
  const OrderedJson record = mcap_contents(file, "a");
  ASSERT_EQ(record.at("world").at("parts").size(), 1U);
  EXPECT_EQ(record.at("world").at("parts").at(0),
            OrderedJson::parse(R"({"shape":"box","size_m":[4.0,5.0,6.0],"p":[1.0,2.0,3.0],)"
                               R"("q":[1.0,0.0,0.0,0.0],"name":"wall"})"));
  ASSERT_EQ(record.at("vehicles").size(), 1U);
  const OrderedJson& vehicle = record.at("vehicles").at(0);
  EXPECT_EQ(vehicle.at("name"), "drone");
  EXPECT_EQ(vehicle.at("system"), 3);
  EXPECT_EQ(vehicle.at("scene").at("parts").size(), 1U);
  EXPECT_EQ(vehicle.at("scene").at("meshes").size(), 1U);
  EXPECT_EQ(vehicle.at("scene").at("rotors").size(), 1U);  // the other is none
  const OrderedJson& truth = vehicle.at("truth");
  EXPECT_EQ(numbers(truth.at("t")).size(), 1U);
  EXPECT_NEAR(numbers(truth.at("x")).at(0), 2, 1e-3);  // north
  EXPECT_NEAR(numbers(truth.at("y")).at(0), 1, 1e-3);
  EXPECT_NEAR(numbers(truth.at("vx")).at(0), 0.25, 2e-3);
  EXPECT_NEAR(numbers(truth.at("q")).at(0), -0.25, 2e-3);
  EXPECT_NEAR(numbers(truth.at("rotor1")).at(0), 400, 1);
}

TEST(McapContents, RefusesAFileWithoutJsonInOneSentence) {
  const std::string file =
      McapBytes().channel(1, 0, "/imu", "cdr").message(1, 0, "abc").message(1, 1, "abc").whole();
  EXPECT_EQ(test::refusal([&] { mcap_contents(file, "a"); }),
            "no JSON message is in this file: 2 message(s) encoded as `cdr` left out");
  EXPECT_THROW(mcap_contents(McapBytes().whole(), "a"), base::ConfigError);
}

TEST(McapContents, FollowsNoTextIntoTheDepth) {
  const std::string deep =
      R"({"a":)" + std::string(1'000'000, '[') + std::string(1'000'000, ']') + "}";
  const std::string file = McapBytes().channel(1, 0, "/a").message(1, 0, deep).whole();
  McapLoss loss;
  mcap_contents(file, "a", &loss);
  EXPECT_EQ(loss.unreadable, 1U);
}

}  // namespace
}  // namespace cas::hils
