// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace cas::casd {

/// Logs that autopilots send while they write them (`log.autopilot`).
struct AutopilotLogConfig {
  bool while_armed = false;  ///< of each vehicle while it is armed; false: while it is heard
  std::vector<std::uint8_t> systems{};  ///< of these vehicles alone; empty: of all

  friend bool operator==(const AutopilotLogConfig&, const AutopilotLogConfig&) = default;
};

}  // namespace cas::casd
