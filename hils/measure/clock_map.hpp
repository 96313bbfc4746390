// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace cas::hils {

/// Maps the clock of a flight log to simulated time: pairs of both, read together now and then,
/// with straight lines between them. Microseconds.
class ClockMap {
 public:
  /// Both clocks at one moment; moments come in order.
  void add(std::int64_t log_us, std::int64_t sim_us);
  /// Simulated time at a moment of the log; beyond the ends the clocks run alike.
  std::int64_t to_sim_us(std::int64_t log_us) const;
  bool empty() const { return pairs_.empty(); }

 private:
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs_;  ///< log, simulated
};

}  // namespace cas::hils
