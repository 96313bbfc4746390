// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/random.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {

/// How late a thread goes on after what it waited for, on a machine of the virtual clock:
/// log-normal, given by its median and its 99th percentile. Both zero: at once.
struct WakeUpFigures {
  double p50_us = 0;
  double p99_us = 0;
};

/// Draws wake-up delays; the same seed gives the same delays.
class WakeUp {
 public:
  WakeUp(const WakeUpFigures& figures, std::uint64_t seed);
  base::Duration draw();
  bool is_instant() const { return median_us_ <= 0; }

 private:
  double median_us_;
  double sigma_ = 0;  ///< of the logarithm
  base::NormalRandom random_;
};

}  // namespace cas::hils
