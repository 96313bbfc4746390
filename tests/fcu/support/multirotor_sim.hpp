// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "base/config/vehicle.hpp"

namespace cas::fcu::test {

/// A small Newton-Euler multirotor in N and D for tests of the controller: rotor lag, thrust and
/// drag torque along each rotor's axis, servos that tilt it, rotor drag in wind, a flat ground to
/// stand on. Independent of libsim.
class MultirotorSim {
 public:
  struct State {
    Eigen::Vector3d p_N = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_N = Eigen::Vector3d::Zero();
    Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
    Eigen::Vector3d w_D = Eigen::Vector3d::Zero();
    base::RotorVector omega;
  };

  explicit MultirotorSim(const base::Vehicle& vehicle, double mass_scale = 1.0, double yaw_rad = 0);

  /// U1 (N), U2, U3, U4 (N m); zero speed when not armed.
  void command(const Eigen::Vector4d& u, bool armed);
  /// Outputs of HIL_ACTUATOR_CONTROLS.
  void command(const std::array<double, base::kMaxOutputs>& outputs, bool armed);
  void set_wind(const Eigen::Vector3d& wind_N) { wind_N_ = wind_N; }
  /// Share of its thrust that a rotor still gives.
  void weaken_rotor(int rotor, double share) { share_[rotor] = share; }
  /// Puts the vehicle somewhere, in flight.
  void place(const State& state) { state_ = state; }

  void step(double dt);

  const State& state() const { return state_; }
  /// Mean specific force over the last step, D, m/s^2.
  const Eigen::Vector3d& specific_force_D() const { return specific_force_D_; }
  bool on_ground() const { return on_ground_; }
  double gravity() const { return kGravity; }

 private:
  static constexpr double kGravity = 9.80665;
  using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  struct Rates {
    Eigen::Vector3d v_N, a_N;
    Eigen::Vector4d q_dot;
    Eigen::Vector3d w_dot;
    base::RotorVector omega_dot;
  };
  Rates rates(const State& s) const;
  void turn_servos(double dt);
  void touch_ground();

  base::Vehicle vehicle_;
  double mass_kg_;
  Eigen::Vector3d inertia_;
  Columns wrench_B_;  // force and moment in B of omega^2, with the servos where they stand
  Eigen::MatrixXd omega_sq_from_u_;
  State state_;
  base::RotorVector omega_command_;
  base::RotorVector tilt_command_;
  base::RotorVector tilt_;
  base::RotorVector share_;
  Eigen::Vector3d wind_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_D_{0, 0, -kGravity};
  bool on_ground_ = true;
};

}  // namespace cas::fcu::test
