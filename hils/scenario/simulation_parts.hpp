// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
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

/// The sensors that a vehicle flies with: a set, or keys of one, over those of its file.
/// @param vehicle  its file
base::ConfigNode flown_sensors(const std::filesystem::path& vehicle,
                               const base::ConfigNode& set_or_keys);
base::ConfigNode flown_sensors(const Scenario& scenario, std::size_t vehicle);

/// Names of the sensors of a set that are added to kFirstPlugins, because it has a block of theirs:
/// "imu_2" (base/config/sensor_names.hpp). A second rangefinder is one of the scenario's plugins.
std::vector<std::string> further_first_sensors(const base::ConfigNode& set);

/// Names of the forces and sensors in front of the scenario's plugins: kFirstPlugins, kAeroPlugin
/// for a vehicle with wings, and the further sensors.
/// @param vehicle  its file @param set  its flown_sensors()
std::vector<std::string> first_plugins(const std::filesystem::path& vehicle,
                                       const base::ConfigNode& set);
/// The forces that move the vehicle, without sensors: where the firmware makes these.
std::vector<std::string> first_forces(const std::filesystem::path& vehicle);
/// Entry of a vehicle's list for a plugin of that name: "imu_2" is imu with `number: 2`.
YAML::Node named_plugin(const std::string& name);

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

}  // namespace cas::hils
