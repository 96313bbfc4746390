// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/config/config.hpp"
#include "base/earth/geodesy.hpp"
#include "mavlink_gen/services/mission_exchange.hpp"

namespace cas::hils {

/// One item of a mission as a scenario or a ground station's plan names it.
struct PlannedItem {
  mavlink::common::MavCmd command{};
  mavlink::common::MavFrame frame = mavlink::common::MavFrame::kGlobalRelativeAltInt;
  std::array<float, 4> params{};  ///< parameters 1 to 4 of the command
  bool local = false;             ///< north and east count in m from home, else in degrees
  double north = 0;               ///< m, or latitude
  double east = 0;                ///< m, or longitude
  double up_m = 0;                ///< as the frame says
};

/// A mission, in the order in which it is flown.
struct MissionPlan {
  std::vector<PlannedItem> items{};

  /// Whether it can be flown from the ground: the first item that flies anywhere is a takeoff.
  bool takes_off() const;
  /// The last item that flies anywhere lands, or returns and lands.
  bool lands() const;
  /// Place among `items` of the item whose MISSION_ITEM_REACHED says that all but the landing was
  /// flown; nullopt where a mission only lands.
  std::optional<std::size_t> last_before_landing() const;
};

/// A waypoint of a mission that the vehicle flies to.
struct MissionPlace {
  std::size_t number = 0;                             ///< of its item, in the plan, from 1
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  ///< north, east, up from home
  double radius_m = 0;  ///< about it, in which it counts as reached, by the plan; 0: the vehicle's
  bool above_terrain = false;  ///< its height counts from the terrain below it, not from home
};

/// A mission for a vehicle whose home is known.
struct HomedMission {
  mav::services::MissionExchange::Items items{};    ///< as they are uploaded
  std::optional<std::uint16_t> last{};              ///< number on the wire of last_before_landing()
  Eigen::Vector3d end_m = Eigen::Vector3d::Zero();  ///< where it ends: north, east, up from home
  double reach_m = 0;                               ///< farthest place, from home
  std::vector<MissionPlace> places{};               ///< of its waypoints, in their order
};

/// Reads `{file: FILE.plan}` (QGroundControl) or `{items: [...]}`. @throws base::ConfigError with
/// file, line and key path
MissionPlan parse_mission(const base::ConfigNode& body);

/// The items as the vehicle takes them.
/// @param home  as the vehicle reports it
/// @param home_first  ArduPilot: item 0 is home and is not flown
HomedMission at_home(const MissionPlan& plan, const base::Geodetic& home, bool home_first);

/// Compass heading `yaw_deg` of a goto or a waypoint, which may be -180 to 360, deg in -180 to 180.
/// @throws base::ConfigError
double heading_deg(const base::ConfigNode& body);

}  // namespace cas::hils
