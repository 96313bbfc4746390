// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "base/config/config.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// Errors of one triad of axes (gyroscope or accelerometer), in SI. Zero switches an error off.
struct TriadParams {
  Eigen::Vector3d stddev = Eigen::Vector3d::Zero();  ///< white noise, deviation of one sample
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();    ///< constant, the same in every run
  Eigen::Vector3d turn_on_bias_stddev = Eigen::Vector3d::Zero();  ///< drawn once per run
  GaussMarkovParams<3> bias_walk;                                 ///< in-run drift of the bias
  Eigen::Matrix3d sensitivity = Eigen::Matrix3d::Identity();      ///< scale errors and misalignment
  double range = 0;                                               ///< clips at +-range
  double lsb = 0;                                                 ///< rounds to multiples
  Eigen::Vector3d vibration =
      Eigen::Vector3d::Zero();  ///< amplitude per rotor at vibration_reference_rad_s
};

struct ImuParams {
  double rate_hz = 0;
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();  ///< from the centre of gravity
  Eigen::Matrix3d R_SB = Eigen::Matrix3d::Identity();      ///< B to the sensor's own axes
  TriadParams gyro;
  TriadParams accel;
  double vibration_reference_rad_s = 0;
};

/// Reads the block `imu`: keys are described in docs/plugins.md.
/// @param step_s  the simulation's step
ImuParams parse_imu_params(const base::ConfigNode& node, double step_s);

}  // namespace cas::sim
