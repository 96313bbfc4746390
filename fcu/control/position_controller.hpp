// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "fcu/control/control_params.hpp"
#include "fcu/control/pid.hpp"
#include "fcu/control/setpoint.hpp"

namespace cas::fcu {

/// Horizontal position and velocity loops of [HILS] Fig. 8: P on position, PID with feed-forward on
/// velocity. Works on the x and y components of its arguments.
class PositionController {
 public:
  void set_params(const ControlParams& params);
  void reset() {
    for (Pid& pid : velocity_) pid.reset();
  }

  /// @param a_N          measured acceleration (the derivative of the velocity), m/s^2
  /// @param saturated_N  the direction in N in which the last answer could not be followed, or zero
  /// @return wanted horizontal acceleration, m/s^2
  Eigen::Vector2d update(const TrajectorySetpoint& setpoint, const Eigen::Vector3d& p_N,
                         const Eigen::Vector3d& v_N, const Eigen::Vector3d& a_N,
                         const Eigen::Vector2d& saturated_N, double dt);

 private:
  double p_ = 1;
  double velocity_limit_ = 1;
  double acceleration_limit_ = 1;
  Pid velocity_[2];
};

/// Vertical position and velocity loops of [HILS] Fig. 8, on the z (down) components: P on
/// position, PID with feed-forward on velocity.
class AltitudeController {
 public:
  void set_params(const ControlParams& params);
  void reset(double integral = 0) { velocity_.reset(integral); }

  /// @param saturation  `up`: the thrust can give no more downward acceleration; `down`: no more
  ///                    upward acceleration (directions of z, which points down)
  /// @return wanted acceleration along Nz (down), m/s^2
  double update(const TrajectorySetpoint& setpoint, double z, double vz, double az,
                Saturation saturation, double dt);

 private:
  double p_ = 1;
  double up_limit_ = 1;
  double down_limit_ = 1;
  Pid velocity_;
};

/// Bounds of the wanted thrust.
struct ThrustLimits {
  double min_n = 0;     ///< along -Dz
  double max_n = 0;     ///< along -Dz
  double tilt_rad = 0;  ///< of -Dz from up
};

/// Attitude and thrust that give an acceleration, and the force that the limits took away.
struct ThrustSetpoint {
  AttitudeSetpoint attitude;
  bool thrust_at_max = false;
  bool thrust_at_min = false;
  Eigen::Vector2d cut_N = Eigen::Vector2d::Zero();  ///< horizontal force not given, N
};

/// Force m (a - g) as a direction for -Dz and a magnitude. When thrust runs out, height comes
/// before horizontal acceleration.
/// @param a_N        wanted acceleration, m/s^2
/// @param mass_kg    m
/// @param gravity    m/s^2, positive
/// @param yaw        heading of Dx, rad
ThrustSetpoint thrust_for_acceleration(const Eigen::Vector3d& a_N, double mass_kg, double gravity,
                                       double yaw, const ThrustLimits& limits);

/// Attitude whose -Dz points along `up_N` (any length) and whose Dx heads to `yaw`.
Eigen::Quaterniond attitude_from_direction(const Eigen::Vector3d& up_N, double yaw);

}  // namespace cas::fcu
