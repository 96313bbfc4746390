// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "hils/scenario/scenario.hpp"

namespace YAML {
class Node;
}

namespace cas::hils {

/// Plugins that each vehicle has in front of the scenario's, where the simulator makes its sensors.
inline constexpr std::array kFirstPlugins{"motor", "imu", "gps", "magnetometer", "barometer"};
/// The plugin of vehicles whose file has a block of this name, behind the first.
inline constexpr const char* kAeroPlugin = "aero";

/// Forces and sensors in front of the scenario's plugins: kFirstPlugins, and kAeroPlugin for a
/// vehicle with wings.
/// @param sensors  the simulator makes them; else forces alone
std::vector<std::string> first_plugins(const ScenarioVehicle& vehicle, bool sensors = true);

/// A copy of a map; an empty map for any other node.
YAML::Node copy(const base::ConfigNode& node);
/// YAML text with a line break at its end.
std::string to_text(const YAML::Node& node);
/// The path without relative parts and, as far as it exists, without symlinks.
std::string full_path(const std::filesystem::path& path);

/// Puts the keys `world`, `model_path`, `missing`, `collada_up_axis`, `home`, `decimal_year` and
/// `weather` of a simulation file.
void put_world(const Scenario& scenario, YAML::Node& root);

/// A vehicle of a simulation file, as yet without sensors and plugins: `name`, `vehicle`, `pose`.
YAML::Node vehicle_node(const ScenarioVehicle& vehicle);

/// Block `sensors`, the same for simulator and controller: the scenario's set at the scenario's
/// rates. A set in a file is given by its full path, because the generated files lie elsewhere.
YAML::Node sensors_node(const Scenario& scenario, std::size_t vehicle);
/// Notes on the origin of a block of sensors, for errors (base/config/config_origin.hpp).
/// @param path  key path of the block in the generated file
std::string sensors_origins(const std::string& path, const base::ConfigNode& set_or_keys);

/// A vehicle's controller file, as yet without `seed`, `pace` and `line`.
YAML::Node controller_node(const Scenario& scenario, std::size_t vehicle);
/// Notes on the origin of a controller file's values, for errors.
std::string controller_origins(const Scenario& scenario, std::size_t vehicle);

}  // namespace cas::hils
