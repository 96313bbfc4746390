// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace cas::mav::services {

/// A flight mode of an autopilot.
struct FlightModeWord {
  std::string_view word;
  std::uint32_t number;                     ///< HEARTBEAT.custom_mode
  bool asked_for = true;                    ///< can be set by its word; others are only shown
  std::optional<std::uint8_t> nav_state{};  ///< PX4's vehicle_status.nav_state; nullopt: none
};

}  // namespace cas::mav::services
