// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"

namespace cas::hils {

/// Name of the vehicle of a run that has but one, and the folder of its topics.
inline constexpr std::string_view kVehicleName = "iris0";

/// The vehicles of a scenario by name, in its order.
using VehicleNames = std::vector<std::string>;
/// Those of a scenario with one vehicle.
inline VehicleNames only_vehicle() { return {std::string(kVehicleName)}; }

/// Reads the optional key `vehicle` of a step or a fault.
///
/// @return its place among `names`; nothing when the key is not there
/// @throws base::ConfigError for a name that is not among them, with those that are
std::optional<std::size_t> parse_vehicle_key(const base::ConfigNode& node,
                                             const VehicleNames& names);

}  // namespace cas::hils
