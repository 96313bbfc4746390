// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/noise_params.hpp"

#include <cmath>
#include <optional>

namespace cas::sim {
namespace {

Eigen::Vector3d non_negative_axes(const base::ConfigNode& node) {
  const Eigen::Vector3d value = parse_axes(node);
  if ((value.array() < 0.0).any()) node.fail("must not be negative");
  return value;
}

double time_constant(const base::ConfigNode& node, const std::string& key, bool zero_allowed) {
  const double value = node.require<double>(key);
  if (value < 0.0 || (value == 0.0 && !zero_allowed)) node.at(key).fail("must be above zero");
  return value;
}

}  // namespace

Eigen::Vector3d parse_white_noise(const base::ConfigNode& node, const Quantity& quantity,
                                  double rate_hz) {
  const std::string stddev_key = quantity.name + "stddev_" + quantity.unit;
  const std::string density_key = quantity.name + "density_" + quantity.unit + "_per_sqrt_hz";
  const auto stddev = node.find(stddev_key);
  const auto density = node.find(density_key);
  if (stddev && density) {
    density->fail("is given beside " + stddev_key + "; white noise has one figure");
  }
  if (!stddev && !density) node.fail("needs " + stddev_key + " or " + density_key);
  const base::ConfigNode& given = stddev ? *stddev : *density;
  const Eigen::Vector3d value = non_negative_axes(given);
  if ((value.array() == 0.0).any()) {
    given.fail("must be above zero: a flight controller takes values that repeat for stale");
  }
  return value * quantity.to_si * (stddev ? 1.0 : std::sqrt(rate_hz));
}

GaussMarkovParams<3> parse_drift(const base::ConfigNode& node, const Quantity& quantity) {
  const std::string walk_key = quantity.name + "bias_walk_" + quantity.unit + "_per_sqrt_s";
  const std::string drift_key = quantity.name + "drift_stddev_" + quantity.unit;
  const auto walk = node.find(walk_key);
  const auto drift = node.find(drift_key);
  if (walk && drift) drift->fail("is given beside " + walk_key + "; drift has one figure");
  if (walk) {
    const double tau = time_constant(node, quantity.name + "bias_time_constant_s", true);
    return {non_negative_axes(*walk) * quantity.to_si, tau};
  }
  if (drift) {
    const double tau = time_constant(node, quantity.name + "drift_time_constant_s", false);
    return GaussMarkovParams<3>::standing(non_negative_axes(*drift) * quantity.to_si, tau);
  }
  return {};
}

double parse_rate(const base::ConfigNode& node, double step_s) {
  const double rate_hz = node.require<double>("rate_hz");
  constexpr double kRounding = 1e-9;
  if (rate_hz <= 0.0) node.at("rate_hz").fail("must be above zero");
  if (rate_hz * step_s > 1.0 + kRounding) {
    node.at("rate_hz").fail("exceeds the simulation's own rate of " + std::to_string(1.0 / step_s) +
                            " Hz");
  }
  return rate_hz;
}

}  // namespace cas::sim
