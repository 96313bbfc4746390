// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "hils/scenario/scenario.hpp"

namespace YAML {
class Node;
}

namespace cas::hils {

/// Plugins that a vehicle has in front of the scenario's, where the simulator makes its sensors.
inline constexpr std::array kFirstPlugins{"motor", "imu", "gps", "magnetometer", "barometer"};

/// Puts the keys `world`, `model_path`, `missing`, `collada_up_axis`, `home` and `decimal_year` of
/// a simulation file.
void put_world(const Scenario& scenario, YAML::Node& root);

/// A vehicle of a simulation file, as yet without sensors and plugins: `name`, `vehicle`, `pose`.
YAML::Node vehicle_node(const ScenarioVehicle& vehicle);

}  // namespace cas::hils
