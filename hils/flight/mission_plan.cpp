// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/mission_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/config/install_paths.hpp"
#include "base/earth/deg_e7.hpp"

namespace cas::hils {
namespace {

using mavlink::common::MavCmd;
using mavlink::common::MavFrame;
using Items = std::vector<PlannedItem>;

constexpr std::size_t kMostItems = 500;
constexpr double kFarthestM = 10'000;
constexpr double kWidestM = 200;  // about a waypoint
constexpr double kLongestHoldS = 3600;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// MAV_CMD_NAV_LAST: commands above it fly nowhere.
constexpr int kLastThatFlies = 95;

bool flies(const PlannedItem& item) { return static_cast<int>(item.command) <= kLastThatFlies; }

bool is_landing(MavCmd command) {
  return command == MavCmd::kNavLand || command == MavCmd::kNavReturnToLaunch;
}

bool has_place(const PlannedItem& item) {
  if (!flies(item) || item.frame == MavFrame::kMission) return false;
  return item.command != MavCmd::kNavReturnToLaunch && item.command != MavCmd::kNavDelay;
}

bool is_relative(MavFrame frame) {
  return frame == MavFrame::kGlobalRelativeAlt || frame == MavFrame::kGlobalRelativeAltInt;
}

bool is_above_terrain(MavFrame frame) {
  return frame == MavFrame::kGlobalTerrainAlt || frame == MavFrame::kGlobalTerrainAltInt;
}

/// What `up_m` of a waypoint counts from.
MavFrame height_frame(const base::ConfigNode& body) {
  const auto word = body.get<std::string>("above", "home");
  if (word == "terrain") return MavFrame::kGlobalTerrainAltInt;
  if (word != "home") body.at("above").fail("must be home or terrain");
  return MavFrame::kGlobalRelativeAltInt;
}

float heading(const base::ConfigNode& body) {
  return body.has("yaw_deg") ? static_cast<float>(heading_deg(body)) : kNan;
}

PlannedItem parse_waypoint(const base::ConfigNode& body) {
  PlannedItem item{.command = MavCmd::kNavWaypoint, .frame = height_frame(body), .local = true};
  item.params = {static_cast<float>(body.get_in("hold_s", 0, 0, kLongestHoldS)),
                 static_cast<float>(body.get_in("radius_m", 0, 0, kWidestM)), 0, heading(body)};
  item.north = body.require_in("north_m", -kFarthestM, kFarthestM);
  item.east = body.require_in("east_m", -kFarthestM, kFarthestM);
  item.up_m = body.require_in("up_m", 0.5, kFarthestM);
  return item;
}

/// An item of a scenario: a word, or a map with one key.
/// @param before  those read so far: a landing comes down where the last one is
PlannedItem parse_item(const base::ConfigNode& node, const Items& before) {
  const bool is_word = node.is_scalar();
  if (!is_word && (!node.is_map() || node.entries().size() != 1)) {
    node.fail("an item is a word or a map with exactly one key, such as 'waypoint: {...}'");
  }
  const std::string word = is_word ? node.as<std::string>() : node.entries().front().first;
  const base::ConfigNode body =
      is_word ? base::ConfigNode::empty(node.path()) : node.entries().front().second;
  if (!body.is_map()) body.fail("the item takes a map");
  if (word == "rtl") {
    return {.command = MavCmd::kNavReturnToLaunch, .frame = MavFrame::kMission, .local = true};
  }
  if (is_word && word != "land") {
    node.fail("an item is a takeoff: {up_m}, a waypoint: {north_m, east_m, up_m}, land or rtl");
  }
  if (word == "waypoint") return parse_waypoint(body);
  if (word == "takeoff") {
    return {.command = MavCmd::kNavTakeoff,
            .params = {0, 0, 0, kNan},
            .local = true,
            .up_m = body.require_in("up_m", 0.5, 1000)};
  }
  if (word != "land")
    node.fail("there is no item '" + word + "'; items are takeoff, waypoint, land, rtl");
  PlannedItem item{.command = MavCmd::kNavLand, .params = {0, 0, 0, kNan}, .local = true};
  const PlannedItem last = before.empty() ? PlannedItem{} : before.back();
  item.north = body.get_in("north_m", last.north, -kFarthestM, kFarthestM);
  item.east = body.get_in("east_m", last.east, -kFarthestM, kFarthestM);
  return item;
}

/// A number of a plan; null is NaN there.
double plan_number(const base::ConfigNode& node) {
  return node.is_null() ? std::numeric_limits<double>::quiet_NaN() : node.as<double>();
}

/// An item of QGroundControl: command, frame, seven parameters.
PlannedItem parse_plan_item(const base::ConfigNode& node) {
  constexpr std::size_t kParams = 7;
  const auto type = node.require<std::string>("type");
  if (type != "SimpleItem") {
    node.at("type").fail("an item of type '" + type + "' is not flown: only SimpleItem is");
  }
  PlannedItem item{.command = static_cast<MavCmd>(node.require_in("command", 1, 65535)),
                   .frame = static_cast<MavFrame>(node.require_in("frame", 0, 255))};
  const bool known = item.frame == MavFrame::kGlobal || item.frame == MavFrame::kMission ||
                     is_relative(item.frame) || is_above_terrain(item.frame);
  if (!known) {
    node.at("frame").fail(
        "the frame is 0 (above sea level), 2 (none), 3 (above home) or 10 (above terrain)");
  }
  const auto params = node.at("params").items();
  if (params.size() != kParams) node.at("params").fail("an item has seven parameters");
  for (std::size_t i = 0; i < item.params.size(); ++i) {
    item.params[i] = static_cast<float>(plan_number(params[i]));
  }
  const double lat_deg = plan_number(params[4]);
  const double lon_deg = plan_number(params[5]);
  const double up_m = plan_number(params[6]);
  if (std::abs(lat_deg) > 90) params[4].fail("a latitude is between -90 and 90 degrees");
  if (std::abs(lon_deg) > 180) params[5].fail("a longitude is between -180 and 180 degrees");
  item.north = std::isfinite(lat_deg) ? lat_deg : 0;
  item.east = std::isfinite(lon_deg) ? lon_deg : 0;
  item.up_m = std::isfinite(up_m) ? up_m : 0;
  return item;
}

/// Refuses missions that no flight can complete.
void check(const MissionPlan& plan, const base::ConfigNode& node) {
  const auto goes_on = [](const PlannedItem& item) {
    return item.command == MavCmd::kNavLoiterUnlim || item.command == MavCmd::kDoJump;
  };
  if (std::ranges::none_of(plan.items, flies)) node.fail("the mission has no item that flies");
  if (plan.items.size() > kMostItems) {
    node.fail(fmt::format("a mission has at most {} items", kMostItems));
  }
  if (std::ranges::any_of(plan.items, goes_on)) {
    node.fail("the mission would not end: it loiters without end (17) or jumps back (177)");
  }
  const auto last = std::find_if(plan.items.rbegin(), plan.items.rend(), flies);
  if (is_above_terrain(last->frame)) {
    node.fail(
        "the mission ends above terrain, whose height the vehicle does not tell: let it land "
        "or return at its end");
  }
  std::size_t landings = 0;
  for (const PlannedItem& item : plan.items) landings += is_landing(item.command) ? 1 : 0;
  if (landings > (plan.lands() ? 1U : 0U)) node.fail("the mission lands before its end");
}

base::Geodetic place_of(const PlannedItem& item, const base::LocalProjection& at_home) {
  if (!item.local) return {item.north, item.east, item.up_m};
  base::Geodetic place = at_home.to_geodetic({item.north, item.east, 0});
  place.alt_m = item.up_m;
  return place;
}

mavlink::common::MissionItemInt to_wire(const PlannedItem& item, const base::Geodetic& place) {
  mavlink::common::MissionItemInt wire;
  wire.frame = item.frame;
  wire.command = item.command;
  wire.autocontinue = 1;
  wire.param1 = item.params[0];
  wire.param2 = item.params[1];
  wire.param3 = item.params[2];
  wire.param4 = item.params[3];
  if (item.command == MavCmd::kNavReturnToLaunch) return wire;
  wire.x = base::deg_e7(place.lat_deg);
  wire.y = base::deg_e7(place.lon_deg);
  wire.z = static_cast<float>(place.alt_m);
  return wire;
}

/// Item 0 of ArduPilot.
mavlink::common::MissionItemInt home_item(const base::Geodetic& home) {
  return to_wire({.command = MavCmd::kNavWaypoint, .frame = MavFrame::kGlobal}, home);
}

}  // namespace

bool MissionPlan::takes_off() const {
  const auto first = std::ranges::find_if(items, flies);
  return first != items.end() && first->command == MavCmd::kNavTakeoff;
}

bool MissionPlan::lands() const {
  const auto last = std::find_if(items.rbegin(), items.rend(), flies);
  return last != items.rend() && is_landing(last->command);
}

std::optional<std::size_t> MissionPlan::last_before_landing() const {
  for (std::size_t i = items.size(); i > 0; --i) {
    if (flies(items[i - 1]) && !is_landing(items[i - 1].command)) return i - 1;
  }
  return std::nullopt;
}

MissionPlan parse_mission(const base::ConfigNode& body) {
  if (body.has("file") == body.has("items")) {
    body.fail("a mission has either a file, of QGroundControl, or items");
  }
  MissionPlan plan;
  if (body.has("items")) {
    for (const base::ConfigNode& node : body.at("items").items()) {
      plan.items.push_back(parse_item(node, plan.items));
    }
    check(plan, body.at("items"));
    return plan;
  }
  // YAML reads JSON, and knows the line of each key.
  const auto file = base::ConfigNode::load(base::find_config(body.at("file")));
  const base::ConfigNode items = file.at("mission").at("items");
  for (const base::ConfigNode& node : items.items()) plan.items.push_back(parse_plan_item(node));
  check(plan, items);
  return plan;
}

HomedMission at_home(const MissionPlan& plan, const base::Geodetic& home, bool home_first) {
  HomedMission mission;
  const base::LocalProjection projection(home);
  if (home_first) mission.items.push_back(home_item(home));
  for (const PlannedItem& item : plan.items) {
    const base::Geodetic place = place_of(item, projection);
    mission.items.push_back(to_wire(item, place));
    if (item.command == MavCmd::kNavReturnToLaunch) mission.end_m.setZero();
    if (!has_place(item)) continue;
    const Eigen::Vector3d local = projection.to_local({place.lat_deg, place.lon_deg, home.alt_m});
    const bool here = !item.local && item.north == 0 && item.east == 0;  // by MAVLink: no place
    if (!here) mission.end_m.head<2>() = local.head<2>();
    const bool above_sea = item.frame == MavFrame::kGlobal;
    const double up_m = above_sea ? item.up_m - home.alt_m : item.up_m;
    mission.end_m.z() = item.command == MavCmd::kNavLand ? 0 : up_m;
    mission.reach_m = std::max(mission.reach_m, mission.end_m.norm());
    if (here || item.command != MavCmd::kNavWaypoint) continue;
    const double radius_m = item.params[1];
    mission.places.push_back({.number = static_cast<std::size_t>(&item - plan.items.data()) + 1,
                              .place_m = mission.end_m,
                              .radius_m = radius_m > 0 ? radius_m : 0,
                              .above_terrain = is_above_terrain(item.frame)});
  }
  if (const auto last = plan.last_before_landing()) {
    mission.last = static_cast<std::uint16_t>(*last + (home_first ? 1 : 0));
  }
  return mission;
}

double heading_deg(const base::ConfigNode& body) {
  return std::remainder(body.require_in("yaw_deg", -180, 360), 360.0);
}

}  // namespace cas::hils
