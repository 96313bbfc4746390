// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/control_cascade.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"
#include "fcu/control/position_controller.hpp"

namespace cas::fcu {
namespace {

constexpr double kGravity_m_s2 = base::kStandardGravity_m_s2;  // the integrator takes the rest

}  // namespace

using Eigen::Vector3d;
using Eigen::Vector4d;

ControlCascade::ControlCascade(const base::Vehicle& vehicle)
    : u1_max_(vehicle.scales.u1_max_n),
      torque_max_(vehicle.scales.u2_max_nm, vehicle.scales.u3_max_nm, vehicle.scales.u4_max_nm),
      yaw_inertia_kg_m2_(vehicle.inertia_kg_m2.z()),
      mixer_(vehicle),
      detector_(vehicle) {}

bool ControlCascade::set_params(const ControlParams& params) {
  params_ = params;
  position_.set_params(params);
  altitude_.set_params(params);
  attitude_.set_params(params);
  rates_.set_params(params);
  return mixer_.set_lost(params.rotors_lost | found_lost_);
}

void ControlCascade::reset() {
  position_.reset();
  altitude_.reset();
  rates_.reset();
  cut_N_.setZero();
  altitude_saturation_ = {};
}

const MixerResult& ControlCascade::update(const ControlSetpoint& setpoint,
                                          const EstimatorState& estimate, double dt) {
  near_ground_ = setpoint.near_ground;
  may_touch_ = setpoint.may_touch;
  if (near_ground_) {
    position_.reset();
    rates_.reset();
  }
  if (setpoint.trajectory) {
    follow_trajectory(setpoint, estimate, dt);
    follow_attitude(estimate, dt);
    look_for_losses(estimate, dt);
  } else if (setpoint.attitude) {
    attitude_setpoint_ = *setpoint.attitude;
    side_N_n_.setZero();
    follow_attitude(estimate, dt);
    look_for_losses(estimate, dt);
  } else {
    reset();
    output_ = MixerResult{};
    detector_.reset();
    if (setpoint.stopped) {
      found_lost_ = told_lost_ = 0;  // on the ground anything may be repaired
      mixer_.set_lost(params_.rotors_lost);
    } else if (setpoint.idle) {
      output_ = mixer_.idle();
    }
  }
  return output_;
}

void ControlCascade::follow_trajectory(const ControlSetpoint& wanted,
                                       const EstimatorState& estimate, double dt) {
  const TrajectorySetpoint& setpoint = *wanted.trajectory;
  const Eigen::Vector2d a_xy =
      position_.update(setpoint, estimate.p_N, estimate.v_N, estimate.a_N, cut_N_, dt);
  const double a_z = altitude_.update(setpoint, estimate.p_N.z(), estimate.v_N.z(),
                                      estimate.a_N.z(), altitude_saturation_, dt);

  if (std::isfinite(setpoint.yaw_rad)) {
    yaw_hold_rad_ = setpoint.yaw_rad;
  } else if (std::isfinite(setpoint.yaw_rate_rad_s)) {
    yaw_hold_rad_ = base::wrap_angle(yaw_hold_rad_ + setpoint.yaw_rate_rad_s * dt);
  }

  // The mass that follows from the hover thrust, not that of the data sheet: a parameter can
  // correct it.
  const double mass = params_.hover_thrust * u1_max_ / kGravity_m_s2;
  side_N_n_ = side_force(a_xy, mass);
  const Eigen::Vector2d by_tilt = a_xy - side_N_n_ / mass;
  const Vector3d acceleration(by_tilt.x(), by_tilt.y(), a_z);
  const double thrust_max = std::min(params_.thrust_max * u1_max_, mixer_.max_thrust_n());
  const double tilt =
      std::fmin(params_.tilt_limit_rad, wanted.tilt_limit_rad);  // of a NaN: the other
  const double usual_min = params_.thrust_min * u1_max_;
  const double thrust_min = std::isfinite(wanted.thrust_min_n) ? wanted.thrust_min_n : usual_min;
  const ThrustSetpoint thrust = thrust_for_acceleration(
      acceleration, mass, kGravity_m_s2, yaw_hold_rad_, {thrust_min, thrust_max, tilt});
  attitude_setpoint_ = thrust.attitude;
  attitude_setpoint_.yaw_rate_rad_s =
      std::isfinite(setpoint.yaw_rate_rad_s) ? setpoint.yaw_rate_rad_s : 0.0;
  // Only the part of the wanted force that lies along today's thrust axis is asked of the rotors.
  const Vector3d up_wanted = thrust.attitude.q_ND * Vector3d::UnitZ();
  const Vector3d up_now = estimate.q_ND * Vector3d::UnitZ();
  attitude_setpoint_.thrust_n =
      std::max(thrust.attitude.thrust_n * up_wanted.dot(up_now), thrust_min);
  cut_N_ = thrust.cut_N;
  altitude_saturation_ = {thrust.thrust_at_min, thrust.thrust_at_max};
  if (!wanted.attitude) return;
  const double lift_n = mass * (kGravity_m_s2 - a_z) - wanted.wing_lift_n;
  hold_height_in(*wanted.attitude, lift_n, thrust_min, up_now);
}

/// Keeps the vertical force in an attitude that something else asks for.
void ControlCascade::hold_height_in(const AttitudeSetpoint& attitude, double lift_n,
                                    double thrust_min_n, const Vector3d& up_now) {
  constexpr double kLeastUpright = 0.5;
  const double most_n = std::min(params_.thrust_max * u1_max_, mixer_.max_thrust_n());
  const double wanted_n = lift_n / std::max(up_now.z(), kLeastUpright);
  attitude_setpoint_ = attitude;
  attitude_setpoint_.thrust_n = std::clamp(wanted_n, thrust_min_n, most_n);
  altitude_saturation_ = {wanted_n <= thrust_min_n, wanted_n >= most_n};
  position_.reset();
  cut_N_.setZero();
  side_N_n_.setZero();
}

void ControlCascade::follow_attitude(const EstimatorState& estimate, double dt) {
  rate_setpoint_ = attitude_.update(attitude_setpoint_, estimate.q_ND, turn_limit_rad_s());
  const Vector3d torque = rates_.update(rate_setpoint_, output_.torque, dt);
  Vector4d demand;
  demand << attitude_setpoint_.thrust_n, torque.cwiseProduct(torque_max_);
  const Vector3d side_D = estimate.q_ND.conjugate() * Vector3d(side_N_n_.x(), side_N_n_.y(), 0);
  output_ = mixer_.mix(demand, !near_ground_, side_D.head<2>());
}

/// Speed of a turn that the heading's loop can brake with what the rotors have to both sides.
double ControlCascade::turn_limit_rad_s() const {
  const double brakes_rad_s2 = mixer_.heading_torque_nm() / yaw_inertia_kg_m2_;
  return params_.yaw_p > 0 ? brakes_rad_s2 / params_.yaw_p : brakes_rad_s2;
}

/// The part of a horizontal acceleration that the rotors give without tilting the vehicle, N.
Eigen::Vector2d ControlCascade::side_force(const Eigen::Vector2d& a_xy, double mass_kg) const {
  const double limit = params_.side_share * mixer_.side_force_n();
  if (limit <= 0 || near_ground_) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d wanted = mass_kg * a_xy;
  const double length = wanted.norm();
  return length > limit ? Eigen::Vector2d(wanted * (limit / length)) : wanted;
}

void ControlCascade::look_for_losses(const EstimatorState& estimate, double dt) {
  if (!params_.detect_rotor_loss) return;
  // Feet that touch the ground turn the vehicle too; while it sinks, nothing has touched.
  constexpr double kSinking_m_s = 0.3;
  if (near_ground_ || (may_touch_ && estimate.v_N.z() < kSinking_m_s)) {
    detector_.reset();
    return;
  }
  const auto rotor = detector_.update(estimate.w_D, output_, mixer_.lost(), dt);
  if (!rotor || has(told_lost_, *rotor)) return;
  told_lost_ |= 1U << *rotor;
  const RotorSet found = found_lost_ | 1U << *rotor;
  const bool left_out = mixer_.set_lost(params_.rotors_lost | found);
  loss_ = RotorLoss{*rotor, left_out, mixer_.heading_torque_nm() > 0};
  if (!left_out) return;
  found_lost_ = found;
  // The integrators have learnt to make up for the lost rotor, and nothing is missing any more.
  rates_.reset();
  detector_.reset();
}

}  // namespace cas::fcu
