// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/rotor_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cas::sim {
namespace {

/// 1 - x, held at 0 beyond x = 1 and rounded at both ends by a cubic, so that it has no kink where
/// a vehicle passes from climb to sink.
/// @param x  axial airspeed over that without thrust, not below 0
inline double axial_fade(double x) {
  constexpr double kRound = 0.04;
  const auto rounded = [](double y) { return y * y * (2 * kRound - y) / (kRound * kRound); };
  if (x >= 1) return 0;
  if (x < kRound) return 1 - rounded(x);
  return x > 1 - kRound ? rounded(1 - x) : 1 - x;
}

}  // namespace

RotorModel::RotorModel(const base::Vehicle& vehicle) : count_(vehicle.rotors.size()) {
  effectiveness_.fill(1.0);
  for (std::size_t i = 0; i < count_; ++i) {
    const base::Rotor& rotor = vehicle.rotors[i];
    Hub& hub = hubs_[i];
    hub.position_B_m = rotor.position_B_m;
    hub.axis_B = rotor.axis_B;
    hub.spin = rotor.spin;
    hub.params = rotor.params;
    if (rotor.wake) {
      hub.upper = static_cast<std::size_t>(rotor.wake->upper);
      hub.wake_loss = 1.0 - rotor.wake->thrust_share;
    }
    if (rotor.tilt) servos_[servo_count_++] = {i, *rotor.tilt};
    propellers_.push_back(rotor.propeller);
    if (rotor.electric && !circuit_) circuit_.emplace(vehicle);
    plain_ = plain_ && !rotor.wake && !rotor.tilt && hub.axis_B == Eigen::Vector3d::UnitZ() &&
             hub.params.flapping_stiffness_nm_rad == 0 && hub.params.inflow_thrust_slope == 0 &&
             !rotor.propeller && !rotor.electric;
  }
}

void RotorModel::initial_states(std::span<double> x) const {
  std::fill(x.begin(), x.end(), 0.0);
  if (circuit_) circuit_->initial_states(battery_of(x));
}

double RotorModel::lag(const base::RotorParams& params, double omega, double target) {
  return std::abs(target) > std::abs(omega) ? params.time_constant_up_s
                                            : params.time_constant_down_s;
}

double RotorModel::speed_derivative(const base::RotorParams& params, double omega, double target) {
  const double tau = lag(params, omega, target);
  return tau > 0 ? (target - omega) / tau : 0.0;  // without lag, limit() sets the speed
}

double RotorModel::dynamic_speed(std::size_t rotor, double omega, double air_density_kg_m3) const {
  const double reference = hubs_[rotor].params.reference_density_kg_m3;
  const double density = reference > 0 ? air_density_kg_m3 / reference : 1.0;
  return effectiveness_[rotor] * density * omega * std::abs(omega);
}

double RotorModel::tilt_rate(const base::TiltServo& servo, double tilt, double target) {
  return std::clamp((target - tilt) / servo.time_constant_s, -servo.rate_rad_s, servo.rate_rad_s);
}

void RotorModel::limit(std::span<double> x) const {
  for (std::size_t i = 0; i < count_; ++i) {
    double& w = x[i];
    const base::RotorParams& params = hubs_[i].params;
    const double target = targets_[i];
    const double most = params.omega_max_rad_s;
    if (circuit_) {
      if (!params.reversible) w = std::max(w, 0.0);  // air may drive it beyond its own most
    } else {
      w = std::clamp(lag(params, w, target) > 0 ? w : target, params.reversible ? -most : 0.0,
                     most);
    }
    if (stopped_[i]) w = 0.0;
  }
  for (std::size_t k = 0; k < servo_count_; ++k) {
    const base::TiltServo& servo = servos_[k].params;
    x[count_ + k] = std::clamp(x[count_ + k], servo.min_rad, servo.max_rad);
  }
  if (circuit_) circuit_->limit(battery_of(x));
}

double RotorModel::ground_effect(double height_m, double radius_m) {
  const double ratio = radius_m / (4.0 * std::max(height_m, 0.5 * radius_m));
  return 1.0 / (1.0 - ratio * ratio);
}

RotorModel::Surroundings RotorModel::surroundings(const BodyState& body,
                                                  const Environment& environment) const {
  const Eigen::Matrix3d R_BW = body.q_WB.conjugate().toRotationMatrix();
  return {.v_air_B = R_BW * (body.v_WB - environment.wind_W),
          .up_B = R_BW.col(2),
          .air_density_kg_m3 = environment.air_density_kg_m3,
          .height_m = environment.height_above_ground_m};
}

Eigen::Matrix3d RotorModel::wind_gradient_B(const BodyState& body, const Environment& environment) {
  const Eigen::Matrix3d R_WB = body.q_WB.toRotationMatrix();
  return R_WB.transpose() * *environment.wind_gradient_W * R_WB;
}

template <bool kPlain>
Eigen::Vector3d RotorModel::air_velocity_B(const Surroundings& around,
                                           const Eigen::Vector3d& w_WB_B,
                                           const Eigen::Vector3d& r_B) {
  Eigen::Vector3d v_B = around.v_air_B + w_WB_B.cross(r_B);
  if constexpr (!kPlain) {
    if (around.wind_gradient_B != nullptr) v_B -= *around.wind_gradient_B * r_B;
  }
  return v_B;
}

double RotorModel::thrust_factor(const base::RotorParams& params, double axial_speed,
                                 double hub_height) {
  double factor = 1.0;
  if (params.ground_effect > 0) {
    factor += params.ground_effect * (ground_effect(hub_height, params.radius_m) - 1.0);
  }
  if (params.zero_thrust_speed_m_s > 0) {
    factor *= axial_fade(std::abs(axial_speed) / params.zero_thrust_speed_m_s);
  }
  return factor;
}

void RotorModel::evaluate(const BodyState& body, const Environment& environment,
                          std::span<const double> x, std::span<double> x_dot,
                          Wrench& wrench) const {
  Surroundings around = surroundings(body, environment);
  if (environment.wind_gradient_W) {
    const Eigen::Matrix3d gradient_B = wind_gradient_B(body, environment);
    around.wind_gradient_B = &gradient_B;
    add_all<false>(around, body.w_WB_B, x, x_dot, wrench);
    return;
  }
  if (plain_) {
    add_all<true>(around, body.w_WB_B, x, x_dot, wrench);
  } else {
    add_all<false>(around, body.w_WB_B, x, x_dot, wrench);
  }
}

template <bool kPlain>
void RotorModel::add_all(const Surroundings& around, const Eigen::Vector3d& w_WB_B,
                         std::span<const double> x, std::span<double> x_dot, Wrench& wrench) const {
  for (std::size_t k = 0; k < servo_count_; ++k) {
    const std::size_t state = count_ + k;
    x_dot[state] = tilt_rate(servos_[k].params, x[state], tilt_targets_[servos_[k].rotor]);
  }
  std::optional<MotorCircuit::Supply> supply;
  if constexpr (!kPlain) {
    if (circuit_) {
      supply = circuit_->solve(x.first(count_), battery_of(x), off_);
      circuit_->battery_derivatives(*supply, battery_of(x), battery_of(x_dot));
    }
  }
  Eigen::Vector3d spin_momentum_B = Eigen::Vector3d::Zero();  // of all rotors, N m s
  for (std::size_t i = 0; i < count_; ++i) {
    if (stopped_[i]) {
      x_dot[i] = 0.0;
      continue;
    }
    const Hub& hub = hubs_[i];
    // With a circuit it follows below, from the load.
    x_dot[i] = !kPlain && circuit_ ? 0.0 : speed_derivative(hub.params, x[i], targets_[i]);
    if constexpr (kPlain) {
      const Motion now{.omega = x[i], .omega_dot = x_dot[i]};
      const HubAir air = hub_air<true>(i, now, w_WB_B, around);
      add_rotor<true>(i, now, air, load<true>(i, now, air, w_WB_B, around), wrench);
      spin_momentum_B.z() += hub.spin * hub.params.inertia_kg_m2 * x[i];
    } else {
      Motion now = motion(i, x, x_dot);
      const HubAir air = hub_air<false>(i, now, w_WB_B, around);
      const Load own = load<false>(i, now, air, w_WB_B, around);
      if (supply) {
        now.omega_dot = x_dot[i] =
            circuit_->acceleration(i, supply->motor_a[i], x[i], shaft_load(i, own.torque));
      }
      add_rotor<false>(i, now, air, own, wrench);
      spin_momentum_B += hub.spin * hub.params.inertia_kg_m2 * x[i] * now.axis_B;
    }
  }
  wrench.torque_B -= w_WB_B.cross(spin_momentum_B);  // gyroscopic torque
}

RotorModel::Motion RotorModel::motion(std::size_t rotor, std::span<const double> x,
                                      std::span<const double> x_dot) const {
  const Hub& hub = hubs_[rotor];
  Motion motion{.omega = x[rotor], .omega_dot = x_dot[rotor], .axis_B = hub.axis_B};
  if (hub.wake_loss > 0 && !stopped_[hub.upper]) {
    // Induced speed goes with the root of the thrust that is left.
    motion.upper_omega = std::sqrt(std::max(0.0, effectiveness_[hub.upper])) * x[hub.upper];
  }
  for (std::size_t k = 0; k < servo_count_; ++k) {
    if (servos_[k].rotor != rotor) continue;
    const Eigen::Vector3d& hinge_B = servos_[k].params.axis_B;
    motion.axis_B = Eigen::AngleAxisd(x[count_ + k], hinge_B) * hub.axis_B;
    motion.axis_dot_B = x_dot[count_ + k] * hinge_B.cross(motion.axis_B);
  }
  return motion;
}

RotorLoad RotorModel::inflow_load(std::size_t rotor, double omega, const Eigen::Vector3d& axis_B,
                                  const Eigen::Vector3d& w_WB_B, const Surroundings& around) const {
  const base::RotorParams& params = hubs_[rotor].params;
  const Eigen::Vector3d& r_B = hubs_[rotor].position_B_m;
  const Eigen::Vector3d v_hub_B = air_velocity_B<false>(around, w_WB_B, r_B);
  const double v_axial = axis_B.dot(v_hub_B);
  const double dynamic = dynamic_speed(rotor, omega, around.air_density_kg_m3);
  const double thrust = params.thrust_coefficient * dynamic *
                        thrust_factor(params, v_axial, around.height_m + around.up_B.dot(r_B));
  const double density = around.air_density_kg_m3;
  if (thrust == 0 || density <= 0) return {};  // it stands, has no blades, or is in no air
  return rotor_load(
      {// The slope goes with the area of the blades over the root of their thrust.
       .slope = std::sqrt(std::abs(effectiveness_[rotor])) * params.inflow_thrust_slope,
       .radius_m = params.radius_m,
       .omega_rad_s = std::abs(omega),
       .density_kg_m3 = density,
       .hover_thrust_n = std::abs(thrust),
       .hover_torque_n_m = params.torque_coefficient * std::abs(dynamic),
       .climb_m_s = std::copysign(1.0, thrust) * v_axial,
       .edgewise_m_s = (v_hub_B - v_axial * axis_B).norm()});
}

base::RotorVector RotorModel::shaft_powers(const BodyState& body, const Environment& environment,
                                           std::span<const double> x) const {
  Surroundings around = surroundings(body, environment);
  Eigen::Matrix3d gradient_B;
  if (environment.wind_gradient_W) {
    gradient_B = wind_gradient_B(body, environment);
    around.wind_gradient_B = &gradient_B;
  }
  const std::array<double, kMaxStates> at_rest{};  // a power does not depend on derivatives
  base::RotorVector powers(rotor_count());
  for (std::size_t i = 0; i < count_; ++i) {
    const base::RotorParams& params = hubs_[i].params;
    const double speed = std::abs(x[i]);
    double power = params.torque_coefficient * (speed * speed * speed);
    if (const auto& propeller = propellers_[i]) {
      const Motion now = motion(i, x, at_rest);
      const double axial = hub_air<false>(i, now, body.w_WB_B, around).v_axial;
      const double density = std::abs(effectiveness_[i]) * around.air_density_kg_m3;
      power = std::max(0.0, x[i] * propeller->torque_nm(density, x[i], axial));
    } else if (params.inflow_thrust_slope > 0) {
      const RotorLoad load =
          inflow_load(i, x[i], motion(i, x, at_rest).axis_B, body.w_WB_B, around);
      power = params.torque_coefficient *
              std::abs(dynamic_speed(i, x[i], around.air_density_kg_m3)) * speed *
              std::max(0.0, load.torque);
    }
    powers[static_cast<Eigen::Index>(i)] = power;
  }
  return powers;
}

template <bool kPlain>
RotorModel::HubAir RotorModel::hub_air(std::size_t rotor, const Motion& motion,
                                       const Eigen::Vector3d& w_WB_B,
                                       const Surroundings& around) const {
  const Eigen::Vector3d& r_B = hubs_[rotor].position_B_m;
  const Eigen::Vector3d v_hub_B = air_velocity_B<kPlain>(around, w_WB_B, r_B);
  const double height = around.height_m + around.up_B.dot(r_B);
  if constexpr (kPlain) {
    return {height, v_hub_B.z(), Eigen::Vector3d(v_hub_B.x(), v_hub_B.y(), 0.0)};
  } else {
    const double v_axial = motion.axis_B.dot(v_hub_B);
    return {height, v_axial, v_hub_B - v_axial * motion.axis_B};
  }
}

template <bool kPlain>
RotorModel::Load RotorModel::load(std::size_t rotor, const Motion& motion, const HubAir& air,
                                  const Eigen::Vector3d& w_WB_B, const Surroundings& around) const {
  const Hub& hub = hubs_[rotor];
  const base::RotorParams& params = hub.params;
  const double omega = motion.omega;
  const double dynamic = dynamic_speed(rotor, omega, around.air_density_kg_m3);
  // [HILS] Eq. (1), (2), less the loss to the rotor above.
  Load load{.thrust = params.thrust_coefficient * dynamic *
                      thrust_factor(params, air.v_axial, air.height),
            .torque = params.torque_coefficient * dynamic};
  if constexpr (!kPlain) {
    if (const auto& propeller = propellers_[rotor]) {
      const double density = effectiveness_[rotor] * around.air_density_kg_m3;
      load = {.thrust = propeller->thrust_n(density, omega, air.v_axial) *
                        thrust_factor(params, air.v_axial, air.height),
              .torque = propeller->torque_nm(density, omega, air.v_axial)};
    } else if (params.inflow_thrust_slope > 0) {
      const RotorLoad share = inflow_load(rotor, omega, motion.axis_B, w_WB_B, around);
      load.thrust *= share.thrust;
      load.torque = share.torque * load.torque;
    }
    if (hub.wake_loss > 0 && omega > 0) {
      load.thrust *= std::max(0.0, 1.0 - hub.wake_loss * motion.upper_omega / omega);
    }
  }
  return load;
}

template <bool kPlain>
void RotorModel::add_rotor(std::size_t rotor, const Motion& motion, const HubAir& air,
                           const Load& load, Wrench& wrench) const {
  const Hub& hub = hubs_[rotor];
  const base::RotorParams& params = hub.params;
  const double omega = motion.omega;
  const double speed = std::abs(omega);

  // Forces at the hub: thrust, and drag.
  Eigen::Vector3d force_B = -params.drag_coefficient * speed * air.v_plane_B;
  if constexpr (kPlain) {
    force_B.z() += load.thrust;
  } else {
    force_B += load.thrust * motion.axis_B;
  }
  wrench.force_B += force_B;
  wrench.torque_B += hub.position_B_m.cross(force_B);

  // Moments: the advancing blade lifts more, so counter-clockwise rotors roll one way and clockwise
  // ones the other; reaction to air drag, [HILS] Eq. (2), to spin-up and to the servo's turn.
  wrench.torque_B -= hub.spin * params.rolling_moment_coefficient * omega * air.v_plane_B;
  if constexpr (!kPlain) {
    if (params.flapping_stiffness_nm_rad > 0) {
      // Beyond an advance ratio of 1 it fades with the rotor's speed: blades that stand do not
      // flap.
      const double tip_speed = speed * params.radius_m;
      const double fastest = std::max(tip_speed, air.v_plane_B.norm());
      const double moment_per_speed =
          fastest > 0 ? effectiveness_[rotor] * params.flapping_stiffness_nm_rad *
                            params.flapping_gain * tip_speed / (fastest * fastest)
                      : 0.0;
      wrench.torque_B -= moment_per_speed * motion.axis_B.cross(air.v_plane_B);
    }
  }
  const double reaction = hub.spin * (load.torque + params.inertia_kg_m2 * motion.omega_dot);
  if constexpr (kPlain) {
    wrench.torque_B.z() -= reaction;
  } else {
    wrench.torque_B -=
        reaction * motion.axis_B + hub.spin * params.inertia_kg_m2 * omega * motion.axis_dot_B;
  }
}

}  // namespace cas::sim
