// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/config/config.hpp"
#include "base/config/sensor_sheets.hpp"
#include "plugins/common/gauss_markov.hpp"

/// Figures of a sensor's sheet as its model takes them: in SI, per sample.
namespace cas::sim {

/// Deviation of one sample. @param to_si  the sheet's unit in SI
inline Eigen::Vector3d white_noise(const base::WhiteNoise& noise, double to_si, double rate_hz) {
  return noise.figure() * to_si * noise.per_sample(rate_hz);
}

/// Zero where the sheet has none. @param to_si  the sheet's unit in SI
GaussMarkovParams<3> drift_of(const base::Drift& drift, double to_si);

/// The same of a sensor with one axis, in the sheet's unit.
inline GaussMarkovParams<1> drift_of_one(const base::Drift& sheet) {
  const GaussMarkovParams<3> drift = drift_of(sheet, 1.0);
  return {drift.walk.head<1>(), drift.time_constant_s};
}

/// Refuses a `rate_hz` above the simulation's own. @throws base::ConfigError
void check_rate(const base::ConfigNode& node, double rate_hz, double step_s);

/// The sheet of a sensor by its reader. @throws base::ConfigError also for a rate above the
/// simulation's own
template <auto read_sheet>
auto read_at_rate(const base::ConfigNode& node, double step_s) {
  const auto sheet = read_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  return sheet;
}

/// `rate_hz`, above zero and at most the simulation's own rate.
double parse_rate(const base::ConfigNode& node, double step_s);

}  // namespace cas::sim
