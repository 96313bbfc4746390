// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
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
  kPartOdometry = 1U << 6U,
};

/// The sensors of a vehicle that have spoken, by kind and number.
class SpokenSensors {
 public:
  constexpr SpokenSensors() = default;
  /// The first of each kind. @param parts  VehiclePart bits
  constexpr SpokenSensors(unsigned parts) {  // NOLINT: the sensors of a vehicle with one of each
    for (std::size_t bit = 0; bit < most_.size(); ++bit) most_[bit] = parts >> bit & 1U;
  }

  /// @param at  of several of a kind, from 0
  void add(VehiclePart part, std::size_t at) {
    std::uint8_t& most = most_[static_cast<std::size_t>(std::countr_zero(unsigned{part}))];
    most = std::max<std::uint8_t>(most, static_cast<std::uint8_t>(at + 1));
  }
  /// The highest number of a kind that has spoken, from 1; 0: none has.
  int most(VehiclePart part) const {
    return most_[static_cast<std::size_t>(std::countr_zero(unsigned{part}))];
  }

 private:
  std::array<std::uint8_t, 7> most_{};
};

/// Parts of a vehicle that can fail.
struct VehicleParts {
  SpokenSensors sensors{};
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
