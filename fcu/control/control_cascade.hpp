// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>

#include "base/config/vehicle.hpp"
#include "fcu/control/attitude_controller.hpp"
#include "fcu/control/control_params.hpp"
#include "fcu/control/mixer.hpp"
#include "fcu/control/position_controller.hpp"
#include "fcu/control/rate_controller.hpp"
#include "fcu/control/rotor_loss.hpp"
#include "fcu/control/setpoint.hpp"
#include "fcu/estimation/estimator.hpp"

namespace cas::fcu {

/// A rotor that was found to be lost.
struct RotorLoss {
  int rotor = 0;              ///< 0..
  bool left_out = false;      ///< the others carry on without it; else nothing has changed
  bool holds_heading = true;  ///< else turning is damped, as far as the others can
};

/// The tracking controller of [HILS] Fig. 8: setpoint and estimate in, U1..U4 out.
///
///   (Xr, Yr) -> position --+
///                          +-> thrust vector -> attitude -> rates -> mixer -> U1..U4
///   (Zr)     -> altitude --+        yaw_r --------^
///
/// A vehicle whose rotors push sideways is not tilted for a trajectory as long as that suffices: a
/// share of the force (ControlParams::side_share) goes to the mixer beside U1..U4.
class ControlCascade {
 public:
  explicit ControlCascade(const base::Vehicle& vehicle);

  /// @return false where the vehicle cannot be flown without the rotors that are lost: it is flown
  ///         with them
  bool set_params(const ControlParams& params);
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
  /// The rotor that was found to be lost since the last call, if any. While the rotors are stopped
  /// only those in ControlParams::rotors_lost are known to be lost.
  std::optional<RotorLoss> take_loss() { return std::exchange(loss_, std::nullopt); }
  /// Thrust that carries the vehicle, N, as the gains' hover thrust says.
  double hover_thrust_n() const { return params_.hover_thrust * u1_max_; }

 private:
  void follow_trajectory(const ControlSetpoint& wanted, const EstimatorState& estimate, double dt);
  void hold_height_in(const AttitudeSetpoint& attitude, double lift_n, double thrust_min_n,
                      const Eigen::Vector3d& up_now);
  void follow_attitude(const EstimatorState& estimate, double dt);
  double turn_limit_rad_s() const;
  Eigen::Vector2d side_force(const Eigen::Vector2d& a_xy, double mass_kg) const;
  void look_for_losses(const EstimatorState& estimate, double dt);

  ControlParams params_;
  double u1_max_;
  Eigen::Vector3d torque_max_;
  double yaw_inertia_kg_m2_;
  PositionController position_;
  AltitudeController altitude_;
  AttitudeController attitude_;
  RateController rates_;
  Mixer mixer_;
  RotorLossDetector detector_;
  RotorSet found_lost_ = 0;
  RotorSet told_lost_ = 0;  // found, left out or not: each is reported once
  std::optional<RotorLoss> loss_;
  Eigen::Vector2d side_N_n_ = Eigen::Vector2d::Zero();  // wanted of the rotors, horizontal
  MixerResult output_;
  AttitudeSetpoint attitude_setpoint_;
  Eigen::Vector3d rate_setpoint_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d cut_N_ = Eigen::Vector2d::Zero();
  Saturation altitude_saturation_;
  double yaw_hold_rad_ = 0;
  bool near_ground_ = false;
  bool may_touch_ = false;
};

}  // namespace cas::fcu
