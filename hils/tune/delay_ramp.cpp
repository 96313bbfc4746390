// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/delay_ramp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cas::hils {

namespace {

constexpr double kLongest_s = 1e4;
constexpr double kLongest_us = 1e6;
constexpr int kMostSteps = 200;
constexpr double kPeriod_s = 0.05;

}  // namespace

DelayRamp DelayRamp::parse(const base::ConfigNode& node) {
  const DelayRamp ramp{.from_s = node.require_in("from_s", 0, kLongest_s),
                       .every_s = node.get_in("every_s", 2, 0.1, kLongest_s),
                       .step_us = node.require_in("step_us", 1, kLongest_us),
                       .most_us = node.require_in("most_us", 1, kLongest_us)};
  const double periods = ramp.every_s / kPeriod_s;
  if (std::abs(periods - std::round(periods)) > 1e-6) {
    node.at("every_s").fail("is a multiple of 0.05 s: so often the simulator looks at its faults");
  }
  if (ramp.steps() < 1 || ramp.steps() > kMostSteps) {
    node.fail(fmt::format("has 1 to {} steps of step_us up to most_us", kMostSteps));
  }
  return ramp;
}

std::string DelayRamp::faults() const {
  std::string list;
  for (int k = 0; k < steps(); ++k) {
    list +=
        fmt::format("{}{{name: delay_{}, at_s: {}, for_s: {}, line: {{extra_delay_us: {:.0f}}}}}",
                    k == 0 ? "" : ", ", k + 1, from_s + k * every_s, every_s, (k + 1) * step_us);
  }
  return "[" + list + "]";
}

double DelayRamp::margin_us(double end_s) const {
  const double borne = std::floor((end_s - from_s) / every_s);
  return std::clamp(borne, 0.0, static_cast<double>(steps())) * step_us;
}

int DelayRamp::steps() const {
  return static_cast<int>(std::min(std::floor(most_us / step_us + 1e-9), kMostSteps + 1.0));
}

}  // namespace cas::hils
