// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fcu/support/multirotor_sim.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu::test {

using Eigen::Vector3d;
using Eigen::Vector4d;

MultirotorSim::MultirotorSim(const base::Vehicle& vehicle, double mass_scale, double yaw_rad)
    : vehicle_(vehicle),
      mass_kg_(vehicle.mass_kg * mass_scale),
      inertia_(vehicle.inertia_kg_m2 * mass_scale),
      wrench_B_(vehicle.effectiveness()) {
  Eigen::MatrixXd u_from_omega_sq(4, wrench_B_.cols());
  u_from_omega_sq << wrench_B_.row(2), wrench_B_.row(3), -wrench_B_.row(4), -wrench_B_.row(5);
  omega_sq_from_u_ = u_from_omega_sq.completeOrthogonalDecomposition().pseudoInverse();
  state_.q_ND = base::quaternion_rpy(0, 0, yaw_rad);
  const int rotors = vehicle.rotor_count();
  state_.omega.setZero(rotors);
  omega_command_.setZero(rotors);
  tilt_command_.setZero(rotors);
  tilt_.setZero(rotors);
  share_.setOnes(rotors);
}

void MultirotorSim::command(const Vector4d& u, bool armed) {
  const Eigen::VectorXd omega_sq = omega_sq_from_u_ * u;
  for (int i = 0; i < omega_command_.size(); ++i) {
    const double top = vehicle_.rotors[static_cast<std::size_t>(i)].params.omega_max_rad_s;
    omega_command_[i] = armed ? std::min(std::sqrt(std::max(omega_sq[i], 0.0)), top) : 0.0;
  }
}

void MultirotorSim::command(const std::array<double, base::kMaxOutputs>& outputs, bool armed) {
  for (int i = 0; i < omega_command_.size(); ++i) {
    const base::Rotor& rotor = vehicle_.rotors[static_cast<std::size_t>(i)];
    const double idle = rotor.params.omega_idle_rad_s;
    const double output = std::clamp(outputs[static_cast<std::size_t>(rotor.output)], 0.0, 1.0);
    omega_command_[i] = armed ? idle + output * (rotor.params.omega_max_rad_s - idle) : 0.0;
    if (!rotor.tilt) continue;
    tilt_command_[i] = rotor.tilt->angle_rad(outputs[static_cast<std::size_t>(rotor.tilt->output)]);
  }
}

MultirotorSim::Rates MultirotorSim::rates(const State& s) const {
  const Eigen::Matrix3d R_ND = s.q_ND.normalized().toRotationMatrix();
  const Vector3d air_D = R_ND.transpose() * (s.v_N - wind_N_);
  Eigen::Matrix<double, 6, 1> wrench_B = Eigen::Matrix<double, 6, 1>::Zero();
  double drag = 0;
  double turn_drag = 0;
  double spin = 0;  // rotor momentum about Dz (down): counter-clockwise from above is negative
  Rates r;
  r.omega_dot.resize(s.omega.size());
  for (int i = 0; i < s.omega.size(); ++i) {
    const base::Rotor& rotor = vehicle_.rotors[static_cast<std::size_t>(i)];
    const double strength = share_[i] * s.omega[i] * s.omega[i];
    wrench_B += strength * wrench_B_.col(i);
    const double rotor_drag = rotor.params.drag_coefficient * std::abs(s.omega[i]);
    drag += rotor_drag;
    turn_drag += rotor_drag * rotor.position_B_m.head<2>().squaredNorm();
    spin -= rotor.params.inertia_kg_m2 * rotor.spin * s.omega[i];
    const double lag = omega_command_[i] > s.omega[i] ? rotor.params.time_constant_up_s
                                                      : rotor.params.time_constant_down_s;
    r.omega_dot[i] = (omega_command_[i] - s.omega[i]) / lag;
  }
  const Vector3d force_D(wrench_B[0] - drag * air_D.x(), -wrench_B[1] - drag * air_D.y(),
                         -wrench_B[2]);
  const Vector3d moment_D(wrench_B[3], -wrench_B[4], -wrench_B[5] - turn_drag * s.w_D.z());
  r.v_N = s.v_N;
  r.a_N = R_ND * force_D / mass_kg_ + Vector3d(0, 0, kGravity);
  const Vector3d momentum = inertia_.cwiseProduct(s.w_D) + Vector3d(0, 0, spin);
  r.w_dot = (moment_D - s.w_D.cross(momentum)).cwiseQuotient(inertia_);
  const Eigen::Quaterniond w(0, s.w_D.x(), s.w_D.y(), s.w_D.z());
  r.q_dot = 0.5 * (s.q_ND * w).coeffs();
  return r;
}

void MultirotorSim::turn_servos(double dt) {
  for (int i = 0; i < tilt_.size(); ++i) {
    const base::Rotor& rotor = vehicle_.rotors[static_cast<std::size_t>(i)];
    if (!rotor.tilt) continue;
    const double most = rotor.tilt->rate_rad_s * dt;
    tilt_[i] += std::clamp(tilt_command_[i] - tilt_[i], -most, most);
  }
  wrench_B_ = vehicle_.effectiveness({tilt_.data(), vehicle_.rotors.size()});
}

void MultirotorSim::step(double dt) {
  const auto moved = [](const State& s, const Rates& r, double h) {
    State out = s;
    out.p_N += h * r.v_N;
    out.v_N += h * r.a_N;
    out.q_ND.coeffs() += h * r.q_dot;
    out.w_D += h * r.w_dot;
    out.omega += h * r.omega_dot;
    return out;
  };
  const Vector3d v_before = state_.v_N;
  turn_servos(dt);
  const Rates k1 = rates(state_);
  const Rates k2 = rates(moved(state_, k1, dt / 2));
  const Rates k3 = rates(moved(state_, k2, dt / 2));
  const Rates k4 = rates(moved(state_, k3, dt));
  state_ = moved(state_, k1, dt / 6);
  state_ = moved(state_, k2, dt / 3);
  state_ = moved(state_, k3, dt / 3);
  state_ = moved(state_, k4, dt / 6);
  state_.q_ND.normalize();
  state_.omega = state_.omega.cwiseMax(0.0);
  touch_ground();
  const Vector3d a_N = (state_.v_N - v_before) / dt;
  specific_force_D_ = state_.q_ND.inverse() * (a_N - Vector3d(0, 0, kGravity));
}

void MultirotorSim::touch_ground() {
  on_ground_ = state_.p_N.z() >= 0;
  if (!on_ground_) return;
  // Feet: no sinking, no sliding, level, until the thrust lifts it.
  state_.p_N.z() = 0;
  state_.v_N.x() = state_.v_N.y() = 0;
  state_.v_N.z() = std::min(0.0, state_.v_N.z());
  state_.w_D.setZero();
  state_.q_ND = base::quaternion_rpy(0, 0, base::euler_rpy(state_.q_ND).z());
}

}  // namespace cas::fcu::test
