// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// What has come from a firmware before its first HEARTBEAT.
struct FirstSign {
  /// A connection or a packet at the simulator; of firmware on a serial line, which has no port
  /// there, a byte.
  bool anything = false;
  std::string words{};  ///< "nobody connected to tcp 127.0.0.1:4560; nothing on link px4 (...)"
};

/// Looks for it at the simulator and at casd.
/// @param stats  sim.stats
/// @param links  link.list
/// @param on_serial_line  the firmware speaks on casd's serial link alone, else on its UDP links
FirstSign first_sign(const nlohmann::json& stats, const nlohmann::json& links,
                     const std::string& vehicle, bool on_serial_line);

/// Why this vehicle does not fit the scenario; nullopt: it does.
/// @param wanted  autopilot_of_plugin() of its world
/// @param has_wing  of the simulated vehicle: it may fly as a plane, else as a multirotor alone
std::optional<std::string> mismatch(const VehicleReport& vehicle, std::string_view wanted,
                                    bool has_wing);

}  // namespace cas::hils
