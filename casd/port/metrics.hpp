// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "casd/autopilot_log/autopilot_logs.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/tlog/tlog_writer.hpp"

namespace cas::casd {

/// What a vehicle says of itself.
struct VehicleMetrics {
  int system = 0;
  bool armed = false;
  bool hil = false;
  double heartbeat_age_s = 0;
};

/// The figures behind the metrics.
struct MetricsSource {
  double uptime_s = 0;
  std::size_t clients = 0;
  /// Clients that the command port refused, by reason.
  std::vector<std::pair<const char*, std::uint64_t>> refused;
  std::vector<LinkStatus> links;
  std::vector<MessageStatus> messages;
  bool messages_cut = false;  ///< some are left out: too many for a page
  std::vector<VehicleMetrics> vehicles{};
  TlogStatus recording{};
  std::optional<AutopilotLogsStatus> autopilot_logs{};  ///< nullopt: none are taken
};

/// The figures in Prometheus' text format 0.0.4: counters end in _total, units are seconds and
/// bytes.
std::string metrics_text(const MetricsSource& source);

}  // namespace cas::casd
