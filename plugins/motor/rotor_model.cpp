// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/rotor_model.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {

RotorModel::RotorModel(const base::Vehicle& vehicle)
    : params_(vehicle.rotor), rotors_(vehicle.rotors) {}

void RotorModel::initial_states(std::span<double> omega) const {
  std::fill(omega.begin(), omega.end(), 0.0);
}

double RotorModel::speed_derivative(double omega, double target) const {
  const double tau = target > omega ? params_.time_constant_up_s : params_.time_constant_down_s;
  return tau > 0 ? (target - omega) / tau : 0.0;  // without lag, limit() sets the speed
}

void RotorModel::limit(std::span<double> omega) const {
  for (int i = 0; i < base::kRotors; ++i) {
    double& w = omega[static_cast<std::size_t>(i)];
    const double target = targets_[i];
    const double tau = target > w ? params_.time_constant_up_s : params_.time_constant_down_s;
    w = std::clamp(tau > 0 ? w : target, 0.0, params_.omega_max_rad_s);
    if (stopped_[static_cast<std::size_t>(i)]) w = 0.0;
  }
}

double RotorModel::ground_effect(double height_m, double radius_m) {
  const double ratio = radius_m / (4.0 * std::max(height_m, 0.5 * radius_m));
  return 1.0 / (1.0 - ratio * ratio);
}

RotorModel::Surroundings RotorModel::surroundings(const BodyState& body,
                                                  const Environment& environment) const {
  const Eigen::Matrix3d R_BW = body.q_WB.conjugate().toRotationMatrix();
  const double reference = params_.reference_density_kg_m3;
  return {.v_air_B = R_BW * (body.v_WB - environment.wind_W),
          .up_B = R_BW.col(2),
          .density_factor = reference > 0 ? environment.air_density_kg_m3 / reference : 1.0,
          .height_m = environment.height_above_ground_m};
}

double RotorModel::thrust_factor(double axial_speed, double hub_height) const {
  double factor = 1.0;
  if (params_.ground_effect > 0) {
    factor += params_.ground_effect * (ground_effect(hub_height, params_.radius_m) - 1.0);
  }
  if (params_.zero_thrust_speed_m_s > 0) {
    factor *= std::clamp(1.0 - std::abs(axial_speed) / params_.zero_thrust_speed_m_s, 0.0, 1.0);
  }
  return factor;
}

void RotorModel::evaluate(const BodyState& body, const Environment& environment,
                          std::span<const double> omega, std::span<double> omega_dot,
                          Wrench& wrench) const {
  const Surroundings around = surroundings(body, environment);
  double spin_momentum = 0.0;  // of all rotors about Bz, N m s
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    if (stopped_[i]) {
      omega_dot[i] = 0.0;
      continue;
    }
    omega_dot[i] = speed_derivative(omega[i], targets_[static_cast<Eigen::Index>(i)]);
    add_rotor(i, omega[i], omega_dot[i], body.w_WB_B, around, wrench);
    spin_momentum += rotors_[i].spin * params_.inertia_kg_m2 * omega[i];
  }
  // Gyroscopic torque: -w x H.
  wrench.torque_B -= body.w_WB_B.cross(Eigen::Vector3d(0.0, 0.0, spin_momentum));
}

void RotorModel::add_rotor(std::size_t rotor, double omega, double omega_dot,
                           const Eigen::Vector3d& w_WB_B, const Surroundings& around,
                           Wrench& wrench) const {
  const Eigen::Vector3d& r_B = rotors_[rotor].position_B_m;
  const double spin = rotors_[rotor].spin;
  const double dynamic =  // what is left of w^2 in thin air and on broken blades
      effectiveness_[static_cast<Eigen::Index>(rotor)] * around.density_factor * omega * omega;

  // Air past the hub: the part in the rotor plane drags and rolls, the axial part takes thrust.
  const Eigen::Vector3d v_hub_B = around.v_air_B + w_WB_B.cross(r_B);
  const Eigen::Vector3d v_plane_B(v_hub_B.x(), v_hub_B.y(), 0.0);
  const double hub_height = around.height_m + around.up_B.dot(r_B);

  // Forces at the hub: [HILS] Eq. (1), and drag.
  Eigen::Vector3d force_B = -params_.drag_coefficient * omega * v_plane_B;
  force_B.z() += params_.thrust_coefficient * dynamic * thrust_factor(v_hub_B.z(), hub_height);
  wrench.force_B += force_B;
  wrench.torque_B += r_B.cross(force_B);

  // Moments: the advancing blade lifts more, so counter-clockwise rotors roll one way and clockwise
  // ones the other; reaction to air drag, [HILS] Eq. (2), and to spin-up.
  wrench.torque_B -= spin * params_.rolling_moment_coefficient * omega * v_plane_B;
  wrench.torque_B.z() -=
      spin * (params_.torque_coefficient * dynamic + params_.inertia_kg_m2 * omega_dot);
}

}  // namespace cas::sim
