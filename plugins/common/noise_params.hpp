// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "base/config/axes.hpp"
#include "base/config/config.hpp"
#include "plugins/common/gauss_markov.hpp"

/// Reading of noise figures. A key always carries its unit, and a figure has one key: a deviation
/// per sample (`gyro_stddev_deg_s`) or a density (`gyro_density_deg_s_per_sqrt_hz`), never both.
namespace cas::sim {

/// Name and unit of a measured quantity as they stand in keys, with the factor to SI.
struct Quantity {
  std::string name;  ///< "gyro_", or "" where the block has one quantity
  std::string unit;  ///< "deg_s"
  double to_si = 1.0;
};

/// White noise as the deviation of one sample, in SI, from `<name>stddev_<unit>` or
/// `<name>density_<unit>_per_sqrt_hz` (deviation = density * sqrt(rate)). One of them must be
/// there; values must not repeat exactly, so zero is refused.
Eigen::Vector3d parse_white_noise(const base::ConfigNode& node, const Quantity& quantity,
                                  double rate_hz);

/// Slow drift in SI: `<name>bias_walk_<unit>_per_sqrt_s` with `<name>bias_time_constant_s` (0: pure
/// random walk), or `<name>drift_stddev_<unit>` with `<name>drift_time_constant_s`. Zero when
/// neither is there.
GaussMarkovParams<3> parse_drift(const base::ConfigNode& node, const Quantity& quantity);

/// `rate_hz`, above zero and at most the simulation's own rate.
double parse_rate(const base::ConfigNode& node, double step_s);

}  // namespace cas::sim
