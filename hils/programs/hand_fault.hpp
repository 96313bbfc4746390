// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>

#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// Place of the vehicle that `params` of fault.inject name; the first where they name none. Only
/// one that says that it is in HIL, and is heard, gets a fault.
/// @throws base::rpc::CallError
std::size_t vehicle_of_fault(const nlohmann::json& params, std::span<const std::uint8_t> systems,
                             std::span<const VehicleReport> vehicles);

}  // namespace cas::hils
