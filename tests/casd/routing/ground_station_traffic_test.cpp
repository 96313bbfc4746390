// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/ground_station_traffic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <string>

#include "casd/routing/routing_rules.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "tests/casd/packets.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

using namespace mavlink::common;

constexpr mav::Source kStation{255, 190};

template <class Message>
bool accepts(const AcceptRule& rule, const Message& message, mav::Source source = kStation) {
  const mav::PacketBuffer buffer = packet(message, source);
  return rule.accepts(view(buffer));
}

Heartbeat heartbeat(MavType type, MavAutopilot autopilot) {
  return {.type = type, .autopilot = autopilot};
}

TEST(StationTraffic, HoldsNoStreamOfTheHilLoopAndNoMeasurement) {
  for (const std::uint32_t id : ground_station_messages()) {
    const std::string name(mav::public_table().find(id)->name);
    EXPECT_FALSE(name.starts_with("HIL_")) << name;
    EXPECT_EQ(name.find("VISION"), std::string::npos) << name;
    EXPECT_EQ(name.find("ESTIMATE"), std::string::npos) << name;
  }
  for (const char* name : {"GPS_INPUT", "ODOMETRY", "ATT_POS_MOCAP", "DISTANCE_SENSOR",
                           "OPTICAL_FLOW_RAD", "OBSTACLE_DISTANCE", "RADIO_STATUS", "ATTITUDE",
                           "PARAM_VALUE", "SYS_STATUS", "LANDING_TARGET"}) {
    const mav::MessageInfo* message = mav::public_table().find(name);
    ASSERT_NE(message, nullptr) << name;
    EXPECT_FALSE(std::ranges::binary_search(ground_station_messages(), message->id)) << name;
  }
}

TEST(StationTraffic, NamesEachMessageOnceInOrder) {
  EXPECT_TRUE(std::ranges::is_sorted(ground_station_messages(), std::ranges::less_equal{}));
  EXPECT_GT(ground_station_messages().size(), 80U);
}

TEST(StationTraffic, IsWhatTheReferenceSays) {
  const std::string whole =
      cas::test::TemporaryFolder::read(cas::test::source_dir() + "/docs/reference/config.md");
  const std::size_t begin = whole.find("\n`traffic: ground_station` is ");
  ASSERT_NE(begin, std::string::npos);
  const std::string text = whole.substr(begin, whole.find("\n\n", begin) - begin);
  std::set<std::string> described;
  const std::regex names("[A-Z][A-Z0-9_]{3,}");
  for (std::sregex_iterator it(text.begin(), text.end(), names), end; it != end; ++it) {
    described.insert(it->str());
  }
  std::set<std::string> known;
  for (const std::uint32_t id : ground_station_messages()) {
    known.emplace(mav::public_table().find(id)->name);
  }
  EXPECT_EQ(described, known);
}

TEST(StationHeartbeat, OfAVehicleIsNoStations) {
  struct HeartbeatCase {
    const char* name;
    MavType type;
    MavAutopilot autopilot;
    mav::Source source;
    bool station;
  };
  const HeartbeatCase rows[] = {
      {"QGroundControl", MavType::kGcs, MavAutopilot::kInvalid, kStation, true},
      {"Companion", MavType::kOnboardController, MavAutopilot::kInvalid, {42, 191}, true},
      {"ScriptThatSaysGeneric",
       MavType::kOnboardController,
       MavAutopilot::kGeneric,
       {42, 191},
       true},
      {"Px4", MavType::kQuadrotor, MavAutopilot::kPx4, {1, 1}, false},
      {"Px4OfAnyId", MavType::kQuadrotor, MavAutopilot::kPx4, {77, 190}, false},
      {"Generic", MavType::kQuadrotor, MavAutopilot::kGeneric, {77, 1}, false}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    EXPECT_EQ(accepts({.ground_station = true}, heartbeat(test.type, test.autopilot), test.source),
              test.station);
  }
}

TEST(AcceptRule, StationTrafficIsWidenedByNamedMessages) {
  const AcceptRule station{.ground_station = true};
  EXPECT_TRUE(accepts(station, CommandLong{}));
  EXPECT_FALSE(accepts(station, HilSensor{}));
  const AcceptRule wider{.ground_station = true, .messages = {HilSensor::kId}};
  EXPECT_TRUE(accepts(wider, HilSensor{}));
  EXPECT_TRUE(accepts(wider, CommandLong{}));
  EXPECT_FALSE(accepts(wider, HilGps{}));
}

TEST(AcceptRule, BlockedSystemsAreRefusedWhateverTheySay) {
  const AcceptRule rule{.block_systems = {1, 2}};
  EXPECT_FALSE(accepts(rule, CommandLong{}, {1, 1}));
  EXPECT_FALSE(accepts(rule, CommandLong{}, {2, 200}));
  EXPECT_TRUE(accepts(rule, CommandLong{}, {3, 1}));
  const AcceptRule both{.systems = {1, 3}, .block_systems = {1}};
  EXPECT_FALSE(accepts(both, CommandLong{}, {1, 1}));
  EXPECT_TRUE(accepts(both, CommandLong{}, {3, 1}));
  EXPECT_FALSE(accepts(both, CommandLong{}, {4, 1}));
}

}  // namespace
}  // namespace cas::casd::test
