// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "base/config/sensor_names.hpp"

namespace cas::sim {

/// Name of the sensor that a plugin's parameters describe, which is that of its topic: "imu", or
/// "imu_2" with `number: 2`.
inline std::string own_sensor_name(std::string_view plugin, const base::ConfigNode& params) {
  return base::sensor_name(plugin, base::sensor_number(params, plugin));
}

}  // namespace cas::sim
