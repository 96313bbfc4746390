// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/clock_map.hpp"

#include <algorithm>
#include <cmath>

namespace cas::hils {

void ClockMap::add(std::int64_t log_us, std::int64_t sim_us) {
  if (!pairs_.empty() && log_us <= pairs_.back().first) return;  // the wall clock was set back
  pairs_.emplace_back(log_us, sim_us);
}

std::int64_t ClockMap::to_sim_us(std::int64_t log_us) const {
  if (pairs_.empty()) return log_us;
  const auto after =
      std::ranges::upper_bound(pairs_, log_us, {}, &std::pair<std::int64_t, std::int64_t>::first);
  if (after == pairs_.begin()) return after->second + (log_us - after->first);
  const auto before = after - 1;
  if (after == pairs_.end()) return before->second + (log_us - before->first);
  const double share = static_cast<double>(log_us - before->first) /
                       static_cast<double>(after->first - before->first);
  return before->second + std::llround(share * static_cast<double>(after->second - before->second));
}

}  // namespace cas::hils
