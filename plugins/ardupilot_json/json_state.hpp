// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

/// The true motion of a vehicle on ArduPilot's terms: forward-right-down and north-east-down, SI.
struct JsonState {
  double timestamp_s = 0;
  Eigen::Vector3d gyro_D = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d accel_D = Eigen::Vector3d::Zero();  ///< specific force, m/s^2
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();      ///< from home, m
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();      ///< m/s
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
  std::optional<double> range_m;  ///< of a rangefinder, when there is one
};

JsonState to_json_state(base::SimTime time, const BodyState& body, const Environment& air);

/// One line as ArduPilot's parser wants it. That is no JSON parser: it searches for keys as
/// substrings, so no further key may contain one of them, and takes '[' only directly behind the
/// colon. The line begins and ends with '\n'.
std::string to_text(const JsonState& state);

}  // namespace cas::sim
