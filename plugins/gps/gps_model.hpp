// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/config/sensor_sheets.hpp"
#include "base/earth/geodesy.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// A satellite receiver: place by [HILS] Eq. (5) (or WGS-84) with white and slowly drifting
/// errors, velocity with white errors. Multipath, satellite geometry and leap seconds are not
/// modelled; the claimed accuracies are the configured ones.
class GpsModel {
 public:
  GpsModel() = default;
  GpsModel(const base::GpsSheet& sheet, const base::LocalProjection& projection,
           std::uint64_t seed);

  /// @param p_N, v_N  antenna's position and velocity, north-east-down, m and m/s
  GpsSample sample(base::SimTime time, const Eigen::Vector3d& p_N, const Eigen::Vector3d& v_N);

  const base::GpsSheet& sheet() const { return sheet_; }

 private:
  bool has_fix(base::SimTime time) const;

  base::GpsSheet sheet_;
  Eigen::Vector3d position_stddev_m_ = Eigen::Vector3d::Zero();  // white, one sample
  Eigen::Vector3d velocity_stddev_m_s_ = Eigen::Vector3d::Zero();
  base::LocalProjection projection_;
  base::NormalRandom random_;
  GaussMarkov<3> drift_;
};

}  // namespace cas::sim
