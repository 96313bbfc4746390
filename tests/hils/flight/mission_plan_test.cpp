// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/mission_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/angles.hpp"
#include "hils/flight/flight_step.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using mavlink::common::MavCmd;

constexpr base::Geodetic kHome{47.397742, 8.545594, 488};
/// The sphere of LocalProjection (6 371 km): one degree of latitude in m.
constexpr double kMetresPerDegree = 111'194.93;

MissionPlan parse(const std::string& text) {
  return parse_mission(base::ConfigNode::parse(text, "mission.yaml"));
}

std::string error_of(const std::string& text) {
  return test::refusal([&] { parse(text); });
}

constexpr const char* kThere = R"(items:
  - takeoff: {up_m: 5}
  - waypoint: {north_m: 30, east_m: 40, up_m: 10, hold_s: 2}
  - land
)";

TEST(MissionPlan, CountsFromTheVehiclesHome) {
  const HomedMission mission = at_home(parse(kThere), kHome, false);
  ASSERT_EQ(mission.items.size(), 3U);
  const auto& waypoint = mission.items[1];
  EXPECT_EQ(waypoint.command, MavCmd::kNavWaypoint);
  EXPECT_EQ(waypoint.param1, 2);
  EXPECT_TRUE(std::isnan(waypoint.param4)) << "the heading is the vehicle's";
  EXPECT_NEAR((waypoint.x * 1e-7 - kHome.lat_deg) * kMetresPerDegree, 30, 0.02);
  EXPECT_FLOAT_EQ(waypoint.z, 10);
  EXPECT_EQ(mission.items[2].x, waypoint.x) << "it lands below its last place";
  EXPECT_NEAR((mission.end_m - Eigen::Vector3d(30, 40, 0)).norm(), 0, 0.02);
  EXPECT_NEAR(mission.reach_m, std::hypot(30, 40, 10), 0.02);
  ASSERT_EQ(mission.places.size(), 1U) << "neither takeoff nor landing is a place to pass";
  EXPECT_EQ(mission.places[0].number, 2U);
  EXPECT_NEAR((mission.places[0].place_m - Eigen::Vector3d(30, 40, 10)).norm(), 0, 0.02);
  EXPECT_EQ(mission.last, 1U) << "what comes after it is the landing";
}

TEST(MissionPlan, TakesACompassHeadingToThreeHundredAndSixtyDegrees) {
  const HomedMission mission =
      at_home(parse("items: [waypoint: {north_m: 1, east_m: 0, up_m: 4, yaw_deg: 270}, land]"),
              kHome, false);
  EXPECT_FLOAT_EQ(mission.items[0].param4, -90);
  const auto goto_yaw_deg = [](const std::string& yaw_deg) {
    const auto steps = base::ConfigNode::parse(
        "[arm, takeoff: {altitude_m: 3}, goto: {north_m: 1, east_m: 0, up_m: 3, yaw_deg: " +
            yaw_deg + "}, hold: {duration_s: 9, measure: true}, land]",
        "steps.yaml");
    return base::degrees(parse_flight(steps, {}).at(2).yaw_rad);
  };
  EXPECT_NEAR(goto_yaw_deg("270"), -90, 1e-9);
  EXPECT_NEAR(goto_yaw_deg("360"), 0, 1e-9);
  EXPECT_NEAR(goto_yaw_deg("180"), 180, 1e-9);
  EXPECT_NEAR(goto_yaw_deg("-180"), -180, 1e-9);
  EXPECT_NE(test::refusal([&] { goto_yaw_deg("361"); }).find("yaw_deg"), std::string::npos);
}

TEST(MissionPlan, OfAPlaneLandsAtAPlaceOfItsOwn) {
  const HomedMission mission =
      at_home(parse("items: [waypoint: {north_m: -500, east_m: 0, up_m: 40, radius_m: 30}, "
                    "land: {north_m: 10, east_m: -20}]"),
              kHome, false);
  ASSERT_EQ(mission.items.size(), 2U);
  EXPECT_EQ(mission.items[0].param2, 30);
  EXPECT_NEAR((mission.end_m - Eigen::Vector3d(10, -20, 0)).norm(), 0, 0.02);
  ASSERT_EQ(mission.places.size(), 1U);
  EXPECT_EQ(mission.places[0].radius_m, 30);
}

TEST(MissionPlan, OfArdupilotBeginsWithHomeThatNobodyFlies) {
  const HomedMission mission = at_home(parse(kThere), kHome, true);
  ASSERT_EQ(mission.items.size(), 4U);
  EXPECT_FLOAT_EQ(mission.items[0].z, 488);
  EXPECT_EQ(mission.items[1].command, MavCmd::kNavTakeoff);
  EXPECT_EQ(mission.last, 2U);
}

TEST(MissionPlan, ThatReturnsEndsAtHome) {
  const MissionPlan plan = parse("items: [waypoint: {north_m: 3, east_m: 4, up_m: 5}, rtl]");
  EXPECT_TRUE(plan.lands());
  EXPECT_FALSE(plan.takes_off());
  EXPECT_EQ(at_home(plan, kHome, false).end_m.norm(), 0);
}

TEST(MissionPlan, KeepsAHeightOverTheTerrain) {
  const HomedMission mission =
      at_home(parse("items: [waypoint: {north_m: 30, east_m: 0, up_m: 25, above: terrain}, "
                    "waypoint: {north_m: 60, east_m: 0, up_m: 25, above: home}]"),
              kHome, false);
  ASSERT_EQ(mission.places.size(), 2U);
  EXPECT_EQ(mission.items[0].frame, mavlink::common::MavFrame::kGlobalTerrainAltInt);
  EXPECT_FLOAT_EQ(mission.items[0].z, 25);
  EXPECT_TRUE(mission.places[0].above_terrain);
  EXPECT_EQ(mission.items[1].frame, mavlink::common::MavFrame::kGlobalRelativeAltInt);
  EXPECT_FALSE(mission.places[1].above_terrain);
}

TEST(MissionPlan, IsReadFromAPlanOfQGroundControl) {
  const cas::test::TemporaryFolder folder;
  const auto file = folder.write("field.plan", R"({"fileType": "Plan", "mission": {"items": [
{"type": "SimpleItem", "command": 22, "frame": 3, "params": [0, 0, 0, null, 47.397742, 8.545594, 7]},
{"type": "SimpleItem", "command": 16, "frame": 0, "params": [0, 0, 0, null, 47.3980115, 8.545594, 498]},
{"type": "SimpleItem", "command": 16, "frame": 10, "params": [0, 0, 0, null, 47.3980115, 8.545594, 10]},
{"type": "SimpleItem", "command": 16, "frame": 3, "params": [0, 0, 0, null, 47.3980115, 8.545594, 10]},
{"type": "SimpleItem", "command": 203, "frame": 2, "params": [0, 0, 0, 0, 1, 0, 0]}]}})");
  const HomedMission mission = at_home(parse("file: " + file.string()), kHome, false);
  ASSERT_EQ(mission.items.size(), 5U);
  ASSERT_EQ(mission.places.size(), 3U);
  EXPECT_NEAR((mission.places[0].place_m - Eigen::Vector3d(29.97, 0, 10)).norm(), 0, 0.05)
      << "its height is above the sea";
  EXPECT_TRUE(mission.places[1].above_terrain);
  EXPECT_EQ(mission.last, 3U) << "a camera flies nowhere";
}

TEST(MissionPlanRefuses, WithOneSentence) {
  struct Refusal {
    const char* name;
    const char* text;
    const char* words;
  };
  const Refusal rows[] = {
      {"Nothing", "{}", "either a file, of QGroundControl, or items"},
      {"NoItems", "items: []", "the mission has no item that flies"},
      {"AnUnknownItem", "items: [orbit: {}]", "items[0]: there is no item 'orbit'"},
      {"APlaceInPart", "items: [waypoint: {north_m: 1, up_m: 3}]", "east_m"},
      {"AnUnknownHeight", "items: [waypoint: {north_m: 1, east_m: 1, up_m: 3, above: sea}]",
       "items[0].waypoint.above: must be home or terrain"},
      {"AnEndAboveTerrain", "items: [waypoint: {north_m: 1, east_m: 1, up_m: 3, above: terrain}]",
       "the mission ends above terrain"},
      {"ALandingOnTheWay", "items: [land, waypoint: {north_m: 1, east_m: 1, up_m: 3}]",
       "the mission lands before its end"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_NE(error_of(row.text).find(row.words), std::string::npos) << error_of(row.text);
  }
}

TEST(MissionPlan, NamesTheLineOfAPlanThatIsWrong) {
  const cas::test::TemporaryFolder folder;
  const auto file = folder.write("field.plan", R"({"mission": {"items": [
{"type": "SimpleItem", "command": 16, "frame": 3, "params": [0, 0, 0, null, 47.4, 8.5, 5]},
{"type": "ComplexItem", "complexItemType": "survey"}]}})");
  const std::string said = error_of("file: " + file.string());
  EXPECT_NE(said.find("field.plan:3: mission.items[1].type: "), std::string::npos) << said;
  EXPECT_NE(said.find("only SimpleItem is"), std::string::npos) << said;
}

}  // namespace
}  // namespace cas::hils
