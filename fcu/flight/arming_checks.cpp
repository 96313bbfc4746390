// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/arming_checks.hpp"

#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu {

std::optional<std::string> reason_not_to_arm(const ArmingInput& in) {
  using M = SensorMonitor;
  constexpr double kTilt_rad = 0.35;
  constexpr double kThrottleUp = 0.6;
  if (!in.sensors.alive(M::kImu, in.now)) return "no accelerometer and gyro data";
  if (!in.sensors.alive(M::kMag, in.now)) return "no compass data";
  if (!in.sensors.alive(M::kBaro, in.now)) return "no barometer data";
  if (!in.estimator.aligned()) return "attitude estimate not aligned";
  const Eigen::Vector3d rpy = base::euler_rpy(in.estimator.state().q_ND);
  if (std::hypot(rpy.x(), rpy.y()) > kTilt_rad) return "vehicle is tilted";
  const bool gps_needed = needs_position(in.mode) || !in.params.arm_without_gps;
  if (gps_needed) {
    if (!in.sensors.alive(M::kGps, in.now)) return "no GPS data";
    if (!in.estimator.heading_valid()) return "heading estimate not valid";
    if (!in.estimator.position_valid()) return "position estimate not valid";
    if (!in.estimator.origin_final()) return "waiting for the position estimate to settle";
  }
  if (in.battery < in.params.battery_critical) return "battery low";
  if (is_manual(in.mode)) {
    if (!in.has_sticks) return "no manual control";
    if (in.sticks_throttle > kThrottleUp) return "throttle is not low";
  }
  if (in.mode == FlightMode::kTermination) return "flight was terminated; reboot";
  return std::nullopt;
}

}  // namespace cas::fcu
