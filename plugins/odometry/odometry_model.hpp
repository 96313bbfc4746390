// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "base/config/config.hpp"
#include "base/config/sensor_sheets.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/odometry_sample.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// White noise of one sample, by axis: what ODOMETRY and VISION_POSITION_ESTIMATE report.
struct OdometryNoise {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< axes of F
  Eigen::Vector3d attitude_rad = Eigen::Vector3d::Zero();  ///< about the axes of D
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< axes of D
  Eigen::Vector3d rate_rad_s = Eigen::Vector3d::Zero();    ///< axes of D
};

struct OdometryParams {
  double rate_hz = 0;
  base::Duration delay{};  ///< from measurement to publication
  OdometryNoise noise;
  Eigen::Vector3d position_walk = Eigen::Vector3d::Zero();  ///< m / sqrt(s)
  double yaw_walk = 0;                                      ///< rad / sqrt(s)
  Eigen::Vector3d origin_N_m = Eigen::Vector3d::Zero();     ///< of F
  double heading_rad = 0;                                   ///< of F, clockwise from north
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();   ///< from the centre of gravity
  base::OdometryMessage message{};
  base::OdometryFrame frame{};
  base::OdometryKind estimator_type{};
  int quality = 0;  ///< %
};

/// Reads the block `odometry`: its keys are those of its sheet (base/config/sensor_sheets.hpp).
OdometryParams parse_odometry_params(const base::ConfigNode& node, double step_s);

/// The motion of the sensor's own point.
struct OdometryTruth {
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  ///< m
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_D = Eigen::Vector3d::Zero();  ///< m/s
  Eigen::Vector3d w_D = Eigen::Vector3d::Zero();  ///< rad/s
};

/// Odometry: the truth in a frame of its own, white noise, and a drift of position and heading.
///
/// The drift is a random walk of each. A change of the heading turns what is flown from then on,
/// and does not move the position: by h(t) it reports the sum of Rz(h) dp, as an estimator does
/// that adds up what it sees. Scale, loss of tracking and loop closures are not modelled; faults
/// (docs/use/plugins.md) make jumps.
class OdometryModel {
 public:
  OdometryModel() = default;
  OdometryModel(const OdometryParams& params, std::uint64_t seed);

  OdometrySample sample(base::SimTime time, const OdometryTruth& truth);

  const OdometryParams& params() const { return params_; }

 private:
  OdometryParams params_;
  base::NormalRandom random_;
  Eigen::Quaterniond q_FN_ = Eigen::Quaterniond::Identity();
  GaussMarkov<3> position_drift_;
  GaussMarkov<1> yaw_drift_;
  /// What the turns of the heading so far have moved the origin by.
  Eigen::Vector3d turned_F_ = Eigen::Vector3d::Zero();
};

}  // namespace cas::sim
