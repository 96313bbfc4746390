// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fcu/support/quad_sim.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu::test {

using Eigen::Vector3d;
using Eigen::Vector4d;

QuadSim::QuadSim(const base::Vehicle& vehicle, double mass_scale, double yaw_rad)
    : vehicle_(vehicle),
      mass_kg_(vehicle.mass_kg * mass_scale),
      inertia_(vehicle.inertia_kg_m2 * mass_scale),
      mixing_(vehicle.mixing_matrix()),
      mixing_inverse_(mixing_.inverse()) {
  state_.q_ND = base::quaternion_rpy(0, 0, yaw_rad);
}

void QuadSim::command(const Vector4d& u, bool armed) {
  if (!armed) {
    omega_command_.setZero();
    return;
  }
  const double top = vehicle_.rotor.omega_max_rad_s * vehicle_.rotor.omega_max_rad_s;
  omega_command_ = (mixing_inverse_ * u).cwiseMax(0.0).cwiseMin(top).cwiseSqrt();
}

QuadSim::Rates QuadSim::rates(const State& s) const {
  const auto& rotor = vehicle_.rotor;
  const Eigen::Matrix3d R_ND = s.q_ND.normalized().toRotationMatrix();
  const Vector4d u = mixing_ * (share_.asDiagonal() * s.omega.cwiseAbs2());
  const Vector3d air_D = R_ND.transpose() * (s.v_N - wind_N_);
  const double drag = rotor.drag_coefficient * s.omega.cwiseAbs().sum();
  const Vector3d force_D(-drag * air_D.x(), -drag * air_D.y(), -u[0]);
  Rates r;
  r.v_N = s.v_N;
  r.a_N = R_ND * force_D / mass_kg_ + Vector3d(0, 0, kGravity);
  for (int i = 0; i < 4; ++i) {
    const double lag =
        omega_command_[i] > s.omega[i] ? rotor.time_constant_up_s : rotor.time_constant_down_s;
    r.omega_dot[i] = (omega_command_[i] - s.omega[i]) / lag;
  }
  double spin = 0;  // rotor momentum about Dz (down): counter-clockwise from above is negative
  for (int i = 0; i < 4; ++i) {
    spin -= vehicle_.rotor.inertia_kg_m2 * vehicle_.rotors[static_cast<std::size_t>(i)].spin *
            s.omega[i];
  }
  const Vector3d momentum = inertia_.cwiseProduct(s.w_D) + Vector3d(0, 0, spin);
  r.w_dot = (u.tail<3>() - s.w_D.cross(momentum)).cwiseQuotient(inertia_);
  const Eigen::Quaterniond w(0, s.w_D.x(), s.w_D.y(), s.w_D.z());
  r.q_dot = 0.5 * (s.q_ND * w).coeffs();
  return r;
}

void QuadSim::step(double dt) {
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

void QuadSim::touch_ground() {
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
