// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "casd/tlog/tlog_folder.hpp"

namespace cas::casd {

/// Logs that autopilots send while they write them (`log.autopilot`).
struct AutopilotLogConfig {
  /// Any peer can send logs: their size is bounded unless the topology says otherwise.
  static constexpr std::uint64_t kMaxBytes = std::uint64_t{4} * 1024 * 1024 * 1024;

  std::filesystem::path folder{};  ///< empty: that of the telemetry logs
  bool while_armed = false;        ///< of each vehicle while it is armed; false: while it is heard
  std::vector<std::uint8_t> systems{};  ///< of these vehicles alone; empty: of all
  int max_files = 0;                    ///< in the folder; 0: any number
  TlogLimits limits{.free_space_min_bytes = TlogLimits::kFreeSpaceMin, .max_bytes = kMaxBytes};

  friend bool operator==(const AutopilotLogConfig&, const AutopilotLogConfig&) = default;
};

}  // namespace cas::casd
