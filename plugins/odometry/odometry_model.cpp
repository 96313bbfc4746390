// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/odometry/odometry_model.hpp"

#include "base/angles.hpp"
#include "base/earth/frames.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

/// Turns vectors by an angle about z, which points down: positive is clockwise from above.
Eigen::Quaterniond about_down(double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
}

GaussMarkovParams<1> yaw_walk_of(const OdometryParams& params) {
  return {GaussMarkovParams<1>::Vector(params.yaw_walk), 0};
}

}  // namespace

OdometryParams parse_odometry_params(const base::ConfigNode& node, double step_s) {
  const base::OdometrySheet sheet = base::read_odometry_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  OdometryParams params;
  params.rate_hz = sheet.rate_hz;
  params.delay = base::from_seconds(sheet.delay_s);
  params.noise = {
      .position_m = white_noise(sheet.position, 1.0, sheet.rate_hz),
      .attitude_rad = white_noise(sheet.attitude, base::kRadPerDeg, sheet.rate_hz),
      .velocity_m_s = white_noise(sheet.velocity, 1.0, sheet.rate_hz),
      .rate_rad_s = white_noise(sheet.rate, base::kRadPerDeg, sheet.rate_hz),
  };
  params.position_walk = sheet.position_walk;
  params.yaw_walk = base::radians(sheet.yaw_walk);
  params.origin_N_m = sheet.origin_N_m;
  params.heading_rad = base::radians(sheet.heading_deg);
  params.position_B_m = sheet.position_B_m;
  params.message = sheet.message;
  params.frame = sheet.frame;
  params.estimator_type = sheet.estimator_type;
  params.quality = sheet.quality;
  return params;
}

OdometryModel::OdometryModel(const OdometryParams& params, std::uint64_t seed)
    : params_(params),
      random_(seed),
      q_FN_(about_down(-params.heading_rad)),
      position_drift_({params.position_walk, 0}, 1.0 / params.rate_hz),
      yaw_drift_(yaw_walk_of(params), 1.0 / params.rate_hz) {}

OdometrySample OdometryModel::sample(base::SimTime time, const OdometryTruth& truth) {
  const Eigen::Vector3d p_F = q_FN_ * (truth.p_N - params_.origin_N_m);

  // Drift: about the sensor's own place, so that a turn alone moves nothing.
  const Eigen::Quaterniond before = about_down(yaw_drift_.value()[0]);
  const Eigen::Quaterniond drifted = about_down(yaw_drift_.advance(random_)[0]);
  turned_F_ += before * p_F - drifted * p_F;
  const Eigen::Vector3d walked_F = position_drift_.advance(random_);

  const OdometryNoise& noise = params_.noise;
  const Eigen::Vector3d turn_D = noise.attitude_rad.cwiseProduct(normal3(random_));
  OdometrySample sample;
  sample.time = time;
  sample.q_FD =
      drifted * q_FN_ * truth.q_ND * base::quaternion_rpy(turn_D.x(), turn_D.y(), turn_D.z());
  sample.position_F_m =
      drifted * p_F + turned_F_ + walked_F + noise.position_m.cwiseProduct(normal3(random_));
  sample.velocity_D_m_s = truth.v_D + noise.velocity_m_s.cwiseProduct(normal3(random_));
  sample.rate_D_rad_s = truth.w_D + noise.rate_rad_s.cwiseProduct(normal3(random_));
  sample.quality = static_cast<std::int8_t>(params_.quality);
  return sample;
}

}  // namespace cas::sim
