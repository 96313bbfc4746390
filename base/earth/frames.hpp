// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

/// The four frames and the only conversions between them.
///   W  world: x east, y north, z up          N  local north-east-down
///   B  body: forward, left, up               D  body: forward, right, down
/// Quaternions are Hamilton; q_WB rotates B vectors into W.
namespace cas::base {

/// W -> N and N -> W (the map is its own inverse): (x, y, z) -> (y, x, -z).
inline Eigen::Vector3d swap_WN(const Eigen::Vector3d& v) { return {v.y(), v.x(), -v.z()}; }
/// B -> D and D -> B (its own inverse): (x, y, z) -> (x, -y, -z).
inline Eigen::Vector3d swap_BD(const Eigen::Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

/// Attitude of D in N from the attitude of B in W.
inline Eigen::Quaterniond q_ND_from_q_WB(const Eigen::Quaterniond& q_WB) {
  const double h = std::sqrt(0.5);
  const Eigen::Quaterniond q_NW(0.0, h, h, 0.0);
  const Eigen::Quaterniond q_BD(0.0, 1.0, 0.0, 0.0);
  return (q_NW * q_WB * q_BD).normalized();
}
/// Attitude of B in W from the attitude of D in N.
inline Eigen::Quaterniond q_WB_from_q_ND(const Eigen::Quaterniond& q_ND) {
  const double h = std::sqrt(0.5);
  const Eigen::Quaterniond q_WN(0.0, h, h, 0.0);
  const Eigen::Quaterniond q_DB(0.0, 1.0, 0.0, 0.0);
  return (q_WN * q_ND * q_DB).normalized();
}

/// Roll, pitch, yaw (rad) of a unit quaternion q_ND, rotation order yaw-pitch-roll (Z-Y'-X'').
/// Pitch is in [-pi/2, pi/2], the others in [-pi, pi]; at pitch +-pi/2 roll and yaw are not unique.
inline Eigen::Vector3d euler_rpy(const Eigen::Quaterniond& q) {
  const double roll =
      std::atan2(2 * (q.w() * q.x() + q.y() * q.z()), 1 - 2 * (q.x() * q.x() + q.y() * q.y()));
  const double s = std::clamp(2 * (q.w() * q.y() - q.z() * q.x()), -1.0, 1.0);
  const double yaw =
      std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z()));
  return {roll, std::asin(s), yaw};
}

/// q_ND of roll, pitch, yaw (rad), rotation order Z-Y'-X''. Inverse of euler_rpy().
inline Eigen::Quaterniond quaternion_rpy(double roll, double pitch, double yaw) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
}

/// Angle (rad) folded into [-pi, pi].
inline double wrap_angle(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace cas::base
