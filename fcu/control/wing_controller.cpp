// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/wing_controller.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"

namespace cas::fcu {

using Eigen::Vector3d;

WingController::WingController(const base::Vehicle& vehicle)
    : vehicle_(vehicle),
      figures_(WingFigures::of(*vehicle.aero)),
      surfaces_(*vehicle.aero, figures_),
      pushers_(pushing_rotors(vehicle)) {
  for (const int channel : surfaces_.channels()) {
    kinds_[static_cast<std::size_t>(channel)] = OutputKind::kServo;
  }
  for (const std::size_t i : pushers_) {
    kinds_[static_cast<std::size_t>(vehicle_.rotors[i].output)] = OutputKind::kMotor;
  }
}

void WingController::set_params(const WingParams& params) {
  params_ = params;
  energy_.set_params(params);
  attitude_.set_params(params);
}

void WingController::reset() {
  energy_.reset();
  attitude_.reset();
}

void WingController::stop() {
  reset();
  outputs_.fill(0.0);
  throttle_ = 0;
}

void WingController::update(const WingSetpoint& setpoint, const EstimatorState& estimate,
                            const Airspeed& airspeed, double dt) {
  set_roll(setpoint, estimate);
  set_pitch_and_throttle(setpoint, estimate, airspeed, dt);

  WingAttitude::Input in;
  in.roll_rad = roll_rad_;
  in.pitch_rad = pitch_rad_;
  in.q_ND = estimate.q_ND;
  in.w_D = estimate.w_D;
  in.airspeed = airspeed;
  in.integrate = !setpoint.unloaded;
  if (std::isfinite(setpoint.heading_rad)) {
    const double yaw = base::euler_rpy(estimate.q_ND).z();
    in.yaw_rate_rad_s = base::wrap_angle(setpoint.heading_rad - yaw) / params_.roll_time_s;
  }
  Vector3d demand = attitude_.update(in, dt);
  demand.y() += trim_demand(figures_, alpha_rad_);
  surfaces_.put(demand, outputs_);
  put_throttle();
}

void WingController::set_roll(const WingSetpoint& setpoint, const EstimatorState& estimate) {
  const double limit = std::fmin(params_.roll_limit_rad, setpoint.roll_limit_rad);
  roll_rad_ = setpoint.roll_rad;
  if (!std::isfinite(roll_rad_)) {
    const double sideways = path_acceleration_m_s2(
        setpoint.path, {.period_s = params_.path_period_s, .damping = params_.path_damping},
        estimate.p_N.head<2>(), estimate.v_N.head<2>());
    roll_rad_ = std::atan(sideways / base::kStandardGravity_m_s2);
  }
  roll_rad_ = std::clamp(roll_rad_, -limit, limit);
}

void WingController::set_pitch_and_throttle(const WingSetpoint& setpoint,
                                            const EstimatorState& estimate,
                                            const Airspeed& airspeed, double dt) {
  TotalEnergy::Input in;
  in.height_error_m = estimate.p_N.z() - setpoint.z_m;
  in.climb_wanted_m_s = setpoint.climb_m_s;
  in.climb_m_s = -estimate.v_N.z();
  in.airspeed_wanted_m_s =
      std::clamp(setpoint.airspeed_m_s, params_.airspeed_min_m_s, params_.airspeed_max_m_s);
  in.airspeed_m_s = airspeed.equivalent_m_s;
  // Along the way, not along the nose: in a turn that points into the circle or out of it.
  in.acceleration_m_s2 = estimate.a_N.dot(estimate.v_N.stableNormalized());
  in.by_climb_alone = setpoint.by_climb_alone;
  if (setpoint.unloaded) energy_.reset();
  const TotalEnergy::Output out = energy_.update(in, dt);

  // The lift that carries the weight, and more of it in a turn, has its own angle of attack.
  constexpr double kSteepest_rad = 1;
  const double roll = std::clamp(base::euler_rpy(estimate.q_ND).x(), -kSteepest_rad, kSteepest_rad);
  const double v = std::max(airspeed.equivalent_m_s, 0.7 * params_.airspeed_min_m_s);
  const double lift_n = vehicle_.mass_kg * base::kStandardGravity_m_s2 / std::cos(roll);
  alpha_rad_ = figures_.angle_of_attack_rad(lift_n, base::isa::density_kg_m3(0) / 2 * v * v);
  const double wanted = alpha_rad_ + out.path_angle_rad + params_.pitch_offset_rad;
  pitch_rad_ = std::isfinite(setpoint.pitch_rad) ? setpoint.pitch_rad : wanted;
  if (std::isfinite(setpoint.alpha_rad)) alpha_rad_ = setpoint.alpha_rad;
  pitch_rad_ = std::clamp(pitch_rad_, params_.pitch_min_rad, params_.pitch_max_rad);
  throttle_ = std::isfinite(setpoint.throttle) ? setpoint.throttle : out.throttle;
}

void WingController::put_throttle() {
  for (const std::size_t i : pushers_) {
    const base::Rotor& rotor = vehicle_.rotors[i];
    const double omega = rotor.params.omega_max_rad_s * std::sqrt(std::max(throttle_, 0.0));
    const double output = throttle_ > 0 ? rotor.output_at(omega) : 0.0;
    outputs_[static_cast<std::size_t>(rotor.output)] = std::clamp(output, 0.0, 1.0);
  }
}

}  // namespace cas::fcu
