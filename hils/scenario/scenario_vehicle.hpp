// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"
#include "hils/flight/vehicle_names.hpp"
#include "hils/scenario/scenario_limits.hpp"

namespace cas::hils {

/// Where a vehicle stands when a run begins, as in a world: x east and y north of home.
struct VehiclePose {
  double x_m = 0;
  double y_m = 0;
  double yaw_deg = 90;  ///< of the nose, counter-clockwise from east: north
};

/// One vehicle of a scenario. Keys are the members' names.
struct ScenarioVehicle {
  std::string name{kVehicleName};  ///< for reports, and the folder of its topics
  std::filesystem::path vehicle;
  std::uint8_t system_id = 1;  ///< of several: 1, 2, ... in the order of the list
  VehiclePose pose;
  base::ConfigNode controller = base::ConfigNode::empty();  ///< keys before the scenario's
  std::optional<base::ConfigNode> sensors;                  ///< instead of the scenario's
  std::optional<Limits> limits;                             ///< instead of the scenario's

  /// Heading of the nose in N.
  double start_yaw_rad() const;
};

/// A block that is handed on to another program, which checks its keys.
base::ConfigNode handed_on(const base::ConfigNode& node, std::string_view key);
/// Reads the block `sensors`, if there is one. @throws base::ConfigError for an unknown set
base::ConfigNode parse_sensors(const base::ConfigNode& node);

/// Reads the vehicles of a scenario: `vehicle`, or the list `vehicles`. @throws base::ConfigError
std::vector<ScenarioVehicle> parse_vehicles(const base::ConfigNode& root);

/// Reads the limits of each vehicle of several; nothing for one alone, whose are the scenario's.
/// @throws base::ConfigError
void parse_vehicle_limits(const base::ConfigNode& root, const std::vector<FlightStep>& steps,
                          std::vector<ScenarioVehicle>& vehicles);

}  // namespace cas::hils
