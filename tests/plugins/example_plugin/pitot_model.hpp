// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"

namespace pitot {

using cas::sim::AirspeedSample;

/// A pitot tube along Bx: q = 1/2 rho v^2 of the air from ahead, with white noise.
class PitotModel {
 public:
  PitotModel() = default;
  /// @param stddev_pa  deviation of one sample
  PitotModel(double stddev_pa, std::uint64_t seed) : stddev_pa_(stddev_pa), random_(seed) {}

  /// @param v_air_W  velocity through the air in W, m/s
  AirspeedSample sample(cas::base::SimTime time, const Eigen::Quaterniond& q_WB,
                        const Eigen::Vector3d& v_air_W, double density_kg_m3);

 private:
  double stddev_pa_ = 0;
  cas::base::NormalRandom random_;
};

}  // namespace pitot
