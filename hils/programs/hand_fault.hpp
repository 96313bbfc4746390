// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// Why a requested fault is not begun, with the code of the answer.
struct HandRefusal {
  int code;
  std::string sentence;
};

/// Place of the vehicle that `params` of fault.inject name; the first where they name none. Only
/// one that says that it is in HIL, and is heard, gets a fault.
/// @throws HandRefusal
std::size_t vehicle_of_fault(const nlohmann::json& params, std::span<const std::uint8_t> systems,
                             std::span<const VehicleReport> vehicles);

}  // namespace cas::hils
