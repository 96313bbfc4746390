// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include "base/clock.hpp"  // the short name of base/time/clock.hpp is installed as well
#include "pitot_model.hpp"

/// 10 m/s from ahead in sea-level air: 61.25 Pa; from behind: nothing.
int main() {
  pitot::PitotModel tube(1e-9, 1);
  const auto east = Eigen::Quaterniond::Identity();
  const double ahead = tube.sample({}, east, {10, 0, 0}, 1.225).differential_pressure_pa;
  const double behind = tube.sample({}, east, {-10, 0, 0}, 1.225).differential_pressure_pa;
  std::printf("ahead %.3f Pa, behind %.3f Pa\n", ahead, behind);
  return std::abs(ahead - 61.25) < 1e-6 && std::abs(behind) < 1e-6 ? 0 : 1;
}
