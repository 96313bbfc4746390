// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/imu/imu_params.hpp"

#include <cmath>

#include "base/earth/frames.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr double kRadPerDeg = M_PI / 180.0;
constexpr double kLargestScaleError = 0.5;

double get_positive_or_off(const base::ConfigNode& node, const std::string& key) {
  const double value = node.get(key, 0.0);
  if (value < 0.0) node.at(key).fail("must not be negative (0 switches it off)");
  return value;
}

/// (I + scale errors) * (small rotation of the axes against the case).
Eigen::Matrix3d parse_sensitivity(const base::ConfigNode& node, const std::string& name) {
  const Eigen::Vector3d scale_error = get_axes(node, name + "scale_error");
  const Eigen::Vector3d angles = get_axes(node, name + "misalignment_deg") * kRadPerDeg;
  if ((scale_error.array().abs() > kLargestScaleError).any()) {
    node.at(name + "scale_error").fail("is a fraction, at most 0.5");
  }
  const Eigen::Vector3d gain = Eigen::Vector3d::Ones() + scale_error;
  const Eigen::Matrix3d turn =
      base::quaternion_rpy(angles.x(), angles.y(), angles.z()).toRotationMatrix().transpose();
  return gain.asDiagonal() * turn;
}

TriadParams parse_triad(const base::ConfigNode& node, const Quantity& quantity, double rate_hz) {
  const std::string& name = quantity.name;
  const double si = quantity.to_si;
  TriadParams triad;
  triad.stddev = parse_white_noise(node, quantity, rate_hz);
  triad.bias = get_axes(node, name + "bias_" + quantity.unit) * si;
  triad.turn_on_bias_stddev = get_axes(node, name + "turn_on_bias_stddev_" + quantity.unit) * si;
  triad.bias_walk = parse_drift(node, quantity);
  triad.sensitivity = parse_sensitivity(node, name);
  triad.range = get_positive_or_off(node, name + "range_" + quantity.unit) * si;
  triad.lsb = get_positive_or_off(node, name + "lsb_" + quantity.unit) * si;
  triad.vibration = get_axes(node, name + "vibration_" + quantity.unit) * si;
  return triad;
}

}  // namespace

ImuParams parse_imu_params(const base::ConfigNode& node, double step_s) {
  ImuParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.position_B_m = get_axes(node, "position_B_m");
  const Eigen::Vector3d rpy = get_axes(node, "mounting_rpy_deg") * kRadPerDeg;
  params.R_SB = base::quaternion_rpy(rpy.x(), rpy.y(), rpy.z()).toRotationMatrix().transpose();
  params.gyro = parse_triad(node, {"gyro_", "deg_s", kRadPerDeg}, params.rate_hz);
  params.accel = parse_triad(node, {"accel_", "m_s2", 1.0}, params.rate_hz);
  const bool vibrates = !params.gyro.vibration.isZero(0.0) || !params.accel.vibration.isZero(0.0);
  params.vibration_reference_rad_s = get_positive_or_off(node, "vibration_reference_rad_s");
  if (vibrates && params.vibration_reference_rad_s <= 0.0) {
    node.fail("gives a vibration amplitude without vibration_reference_rad_s");
  }
  return params;
}

}  // namespace cas::sim
