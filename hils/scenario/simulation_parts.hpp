// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "hils/scenario/scenario.hpp"

namespace YAML {
class Node;
}

namespace cas::hils {

/// Plugins that a vehicle has in front of the scenario's, where the simulator makes its sensors.
inline constexpr std::array kFirstPlugins{"motor", "imu", "gps", "magnetometer", "barometer"};

/// A copy of a map; of any other node an empty map.
YAML::Node copy(const base::ConfigNode& node);
std::string to_text(const YAML::Node& node);
/// A path that holds from every folder.
std::string full_path(const std::filesystem::path& path);

/// Puts the keys `world`, `model_path`, `missing`, `collada_up_axis`, `home` and `decimal_year` of
/// a simulation file.
void put_world(const Scenario& scenario, YAML::Node& root);

/// A vehicle of a simulation file, as yet without sensors and plugins: `name`, `vehicle`, `pose`.
YAML::Node vehicle_node(const ScenarioVehicle& vehicle);

/// Block `sensors`, the same for simulator and controller: the scenario's set at the scenario's
/// rates. A set in a file is given by its full path, because the generated files lie elsewhere.
YAML::Node sensors_node(const Scenario& scenario, std::size_t vehicle);
/// Where the values of such a block came from, for errors (base/config/config_origin.hpp).
/// @param path  of the block
std::string sensors_origins(const std::string& path, const base::ConfigNode& set_or_keys);

/// A vehicle's controller file, as yet without `seed`, `pace` and `line`.
YAML::Node controller_node(const Scenario& scenario, std::size_t vehicle);
/// Where its values came from.
std::string controller_origins(const Scenario& scenario, std::size_t vehicle);

}  // namespace cas::hils
