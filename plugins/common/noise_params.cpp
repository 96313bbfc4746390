// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/noise_params.hpp"

#include <string>

namespace cas::sim {

GaussMarkovParams<3> drift_of(const base::Drift& drift, double to_si) {
  if (drift.bias_walk) return {*drift.bias_walk * to_si, drift.bias_time_constant_s};
  if (!drift.stddev) return {};
  return GaussMarkovParams<3>::standing(*drift.stddev * to_si, drift.time_constant_s);
}

void check_rate(const base::ConfigNode& node, double rate_hz, double step_s) {
  constexpr double kRounding = 1e-9;
  if (rate_hz * step_s <= 1.0 + kRounding) return;
  node.at("rate_hz").fail("exceeds the simulation's own rate of " + std::to_string(1.0 / step_s) +
                          " Hz");
}

double parse_rate(const base::ConfigNode& node, double step_s) {
  const double rate_hz = node.require<double>("rate_hz");
  if (rate_hz <= 0.0) node.at("rate_hz").fail("must be above zero");
  check_rate(node, rate_hz, step_s);
  return rate_hz;
}

}  // namespace cas::sim
