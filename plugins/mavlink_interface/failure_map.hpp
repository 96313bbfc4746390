// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mavlink_gen/services/failure_order.hpp"

namespace cas::sim {

/// Parts of a vehicle that a failure may need, as bits.
enum VehiclePart : std::uint8_t {
  kPartImu = 1U << 0U,
  kPartGps = 1U << 1U,
  kPartMagnetometer = 1U << 2U,
  kPartBarometer = 1U << 3U,
  kPartRangefinder = 1U << 4U,
  kPartAirspeed = 1U << 5U,
};

/// Parts of a vehicle that can fail.
struct VehicleParts {
  std::uint8_t sensors = 0;  ///< VehiclePart of those that have spoken
  int rotors = 0;
};

/// Orders for plugin `fault` (libsim/api/fault_order.hpp) that make a MAVLink failure physical:
/// first the end of an earlier failure there, then, unless it is FAILURE_TYPE_OK, the new one.
///
/// One table holds every unit and type; they act like the failures of a campaign
/// (docs/use/campaign.md). Gyro and accelerometer are one chip, whose samples come together: single
/// ones stick or read wrong, but do not fall silent.
/// @return nullopt if there is no such physical failure, or the vehicle lacks the part
std::optional<std::vector<std::string>> fault_orders(const mav::services::FailureOrder& failure,
                                                     const VehicleParts& parts);

/// Why there are no fault_orders().
mav::services::FailureRefusal why_no_orders(const mav::services::FailureOrder& failure,
                                            const VehicleParts& parts);

}  // namespace cas::sim
