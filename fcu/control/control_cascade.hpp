// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/config/vehicle.hpp"
#include "fcu/control/attitude_controller.hpp"
#include "fcu/control/control_params.hpp"
#include "fcu/control/mixer.hpp"
#include "fcu/control/position_controller.hpp"
#include "fcu/control/rate_controller.hpp"
#include "fcu/control/setpoint.hpp"
#include "fcu/estimation/estimator.hpp"

namespace cas::fcu {

/// The tracking controller of [HILS] Fig. 8: setpoint and estimate in, U1..U4 out.
///
///   (Xr, Yr) -> position --+
///                          +-> thrust vector -> attitude -> rates -> mixer -> U1..U4
///   (Zr)     -> altitude --+        yaw_r --------^
class ControlCascade {
 public:
  explicit ControlCascade(const base::Vehicle& vehicle);

  void set_params(const ControlParams& params);
  /// Forgets the integrators (before a take-off).
  void reset();

  /// Takes one gyro sample; call it for each, also between control steps.
  void on_rates(const Eigen::Vector3d& w_D, double dt) { rates_.on_rates(w_D, dt); }

  /// One control step.
  const MixerResult& update(const ControlSetpoint& setpoint, const EstimatorState& estimate,
                            double dt);

  const MixerResult& output() const { return output_; }
  const AttitudeSetpoint& attitude_setpoint() const { return attitude_setpoint_; }
  const Eigen::Vector3d& rate_setpoint() const { return rate_setpoint_; }
  const Mixer& mixer() const { return mixer_; }
  /// Thrust that carries the vehicle, N, as the gains' hover thrust says.
  double hover_thrust_n() const { return params_.hover_thrust * u1_max_; }

 private:
  void follow_trajectory(const TrajectorySetpoint& setpoint, double tilt_limit_rad,
                         const EstimatorState& estimate, double dt);
  void follow_attitude(const EstimatorState& estimate, double dt);

  ControlParams params_;
  double u1_max_;
  Eigen::Vector3d torque_max_;
  PositionController position_;
  AltitudeController altitude_;
  AttitudeController attitude_;
  RateController rates_;
  Mixer mixer_;
  MixerResult output_;
  AttitudeSetpoint attitude_setpoint_;
  Eigen::Vector3d rate_setpoint_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d cut_N_ = Eigen::Vector2d::Zero();
  Saturation altitude_saturation_;
  double yaw_hold_rad_ = 0;
  bool near_ground_ = false;
};

}  // namespace cas::fcu
