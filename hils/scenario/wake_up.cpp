// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/wake_up.hpp"

#include <algorithm>
#include <cmath>

namespace cas::hils {

WakeUp::WakeUp(const WakeUpFigures& figures, std::uint64_t seed)
    : median_us_(figures.p50_us), random_(seed) {
  constexpr double kNormal99 = 2.326348;  // 99th percentile of the standard normal distribution
  if (median_us_ <= 0) return;
  sigma_ = std::log(std::max(figures.p99_us, median_us_) / median_us_) / kNormal99;
}

base::Duration WakeUp::draw() {
  if (is_instant()) return {};
  return base::from_seconds(1e-6 * median_us_ * std::exp(sigma_ * random_()));
}

}  // namespace cas::hils
