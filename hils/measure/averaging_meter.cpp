// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/averaging_meter.hpp"

#include <cstddef>

namespace cas::hils {

double averaging_meter_hz(std::span<const std::int64_t> arrivals_ns, std::int64_t until_ns) {
  constexpr std::int64_t kPeriodNs = 1'000'000'000;
  constexpr double kGain = 0.2;
  if (arrivals_ns.empty()) return 0;
  double shown_hz = 0;
  std::size_t next = 1;
  for (std::int64_t end = arrivals_ns.front() + kPeriodNs; end <= until_ns; end += kPeriodNs) {
    std::size_t count = 0;
    for (; next < arrivals_ns.size() && arrivals_ns[next] <= end; ++next) ++count;
    shown_hz += kGain * (static_cast<double>(count) - shown_hz);
  }
  return shown_hz;
}

}  // namespace cas::hils
