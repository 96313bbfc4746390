// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/odometry/odometry_messages.hpp"

#include <array>
#include <cstddef>

#include "base/earth/frames.hpp"

namespace cas::sim {

namespace mv = mavlink::common;

namespace {

/// The upper right half, row by row, of a diagonal matrix of 6 by 6.
std::array<float, 21> covariance(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  constexpr std::array<std::size_t, 6> kDiagonal{0, 6, 11, 15, 18, 20};
  std::array<float, 21> upper{};
  for (std::size_t i = 0; i < kDiagonal.size(); ++i) {
    const double stddev =
        i < 3 ? first[static_cast<Eigen::Index>(i)] : second[static_cast<Eigen::Index>(i - 3)];
    upper[kDiagonal[i]] = static_cast<float>(stddev * stddev);
  }
  return upper;
}

template <class Message>
void put_position(const OdometrySample& sample, Message& message) {
  message.x = static_cast<float>(sample.position_F_m.x());
  message.y = static_cast<float>(sample.position_F_m.y());
  message.z = static_cast<float>(sample.position_F_m.z());
}

}  // namespace

mv::Odometry to_odometry(const OdometrySample& sample, const OdometryParams& params) {
  mv::Odometry message;
  message.time_usec = base::to_time_usec(sample.time);
  message.frame_id = params.frame == base::OdometryFrame::kLocalNed ? mv::MavFrame::kLocalNed
                                                                    : mv::MavFrame::kLocalFrd;
  message.child_frame_id = mv::MavFrame::kBodyFrd;
  put_position(sample, message);
  const Eigen::Quaternionf q = sample.q_FD.cast<float>();
  message.q = {q.w(), q.x(), q.y(), q.z()};
  const Eigen::Vector3f v = sample.velocity_D_m_s.cast<float>();
  message.vx = v.x();
  message.vy = v.y();
  message.vz = v.z();
  const Eigen::Vector3f w = sample.rate_D_rad_s.cast<float>();
  message.rollspeed = w.x();
  message.pitchspeed = w.y();
  message.yawspeed = w.z();
  message.pose_covariance = covariance(params.noise.position_m, params.noise.attitude_rad);
  message.velocity_covariance = covariance(params.noise.velocity_m_s, params.noise.rate_rad_s);
  message.reset_counter = sample.reset_counter;
  message.estimator_type = static_cast<mv::MavEstimatorType>(params.estimator_type);
  message.quality = sample.quality;
  return message;
}

mv::VisionPositionEstimate to_vision_position_estimate(const OdometrySample& sample,
                                                       const OdometryParams& params) {
  mv::VisionPositionEstimate message;
  message.usec = base::to_time_usec(sample.time);
  put_position(sample, message);
  const Eigen::Vector3f rpy = base::euler_rpy(sample.q_FD).cast<float>();
  message.roll = rpy.x();
  message.pitch = rpy.y();
  message.yaw = rpy.z();
  message.covariance = covariance(params.noise.position_m, params.noise.attitude_rad);
  message.reset_counter = sample.reset_counter;
  return message;
}

}  // namespace cas::sim
