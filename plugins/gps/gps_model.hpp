// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/config/config.hpp"
#include "base/earth/geodesy.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// A stretch of time without a position fix.
struct FixLoss {
  base::SimTime from;
  base::SimTime to;
};

struct GpsParams {
  double rate_hz = 0;
  base::Duration delay{};  ///< from measurement to publication
  Eigen::Vector3d position_stddev_m =
      Eigen::Vector3d::Zero();  ///< white, north, east, down, one sample
  GaussMarkovParams<3> position_drift;
  Eigen::Vector3d velocity_stddev_m_s = Eigen::Vector3d::Zero();  ///< white, one sample
  Eigen::Vector3d antenna_B_m = Eigen::Vector3d::Zero();          ///< from the centre of gravity
  double eph_m = 0;  ///< accuracy in the receiver's report, 1 sigma
  double epv_m = 0;
  std::uint8_t satellites = 0;
  base::SimTime first_fix;  ///< no fix before this moment
  std::vector<FixLoss> fix_losses;
  std::optional<base::EarthModel> earth_model;  ///< nullopt: the world's own projection
};

/// Reads the block `gps`: its keys are those of its sheet (base/config/sensor_sheets.hpp).
GpsParams parse_gps_params(const base::ConfigNode& node, double step_s);

/// A satellite receiver: place by [HILS] Eq. (5) (or WGS-84) with white and slowly drifting
/// errors, velocity with white errors. Multipath, satellite geometry and leap seconds are not
/// modelled; the claimed accuracies are the configured ones.
class GpsModel {
 public:
  GpsModel() = default;
  GpsModel(const GpsParams& params, const base::LocalProjection& projection, std::uint64_t seed);

  /// @param p_N, v_N  antenna's position and velocity, north-east-down, m and m/s
  GpsSample sample(base::SimTime time, const Eigen::Vector3d& p_N, const Eigen::Vector3d& v_N);

  const GpsParams& params() const { return params_; }

 private:
  bool has_fix(base::SimTime time) const;

  GpsParams params_;
  base::LocalProjection projection_;
  base::NormalRandom random_;
  GaussMarkov<3> drift_;
};

}  // namespace cas::sim
