// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "casd/counters/link_counters.hpp"

namespace cas::casd {

/// What the text tells.
struct MetricsSource {
  double uptime_s = 0;
  std::size_t clients = 0;
  std::vector<LinkStatus> links;
  std::vector<MessageStatus> messages;
};

/// The figures in Prometheus' text format 0.0.4: counters end in _total, units are seconds and
/// bytes.
std::string metrics_text(const MetricsSource& source);

}  // namespace cas::casd
