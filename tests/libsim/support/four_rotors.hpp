// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

#include "libsim/api/world.hpp"

namespace cas::sim::test {

/// Figures of a quadrotor with rotor lag, thrust, drag torque, gyroscopic coupling and spin-up.
struct RotorFigures {
  std::array<Eigen::Vector3d, 4> position_B{
      Eigen::Vector3d{0.13, -0.22, 0.02}, Eigen::Vector3d{-0.13, 0.20, 0.02},
      Eigen::Vector3d{0.13, 0.22, 0.02}, Eigen::Vector3d{-0.13, -0.20, 0.02}};
  std::array<double, 4> spin{1, 1, -1, -1};  // +1 counter-clockwise
  double thrust = 5.84e-6;                   // N s^2
  double torque = 3.504e-7;                  // N m s^2
  double inertia = 3.2e-5;                   // kg m^2
  double time_constant = 0.02;               // s
};

/// Rotors on their way to commanded speeds. States: speeds of the rotors, rad/s.
class FourRotors final : public ForceModel {
 public:
  explicit FourRotors(const Eigen::Vector4d& command, const RotorFigures& figures = {})
      : command_(command), f_(figures) {}

  void set_command(const Eigen::Vector4d& command) { command_ = command; }

  int state_count() const override { return 4; }
  void initial_states(std::span<double> x) const override { std::fill(x.begin(), x.end(), 0.0); }

  void evaluate(const BodyState& body, const Environment&, std::span<const double> x,
                std::span<double> x_dot, Wrench& wrench) const override {
    double h_rotors = 0;  // angular momentum along z of B
    double h_rotors_dot = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      x_dot[i] = (command_[static_cast<Eigen::Index>(i)] - x[i]) / f_.time_constant;
      const Eigen::Vector3d thrust_B(0, 0, f_.thrust * x[i] * x[i]);
      wrench.force_B += thrust_B;
      wrench.torque_B += f_.position_B[i].cross(thrust_B);
      wrench.torque_B.z() -= f_.spin[i] * f_.torque * x[i] * x[i];
      h_rotors += f_.inertia * f_.spin[i] * x[i];
      h_rotors_dot += f_.inertia * f_.spin[i] * x_dot[i];
    }
    wrench.torque_B -= body.w_WB_B.cross(Eigen::Vector3d(0, 0, h_rotors));
    wrench.torque_B.z() -= h_rotors_dot;
  }

 private:
  Eigen::Vector4d command_;
  RotorFigures f_;
};

/// A constant force along z of B.
class SteadyThrust final : public ForceModel {
 public:
  explicit SteadyThrust(double newton) : newton_(newton) {}
  void set(double newton) { newton_ = newton; }
  int state_count() const override { return 0; }
  void initial_states(std::span<double>) const override {}
  void evaluate(const BodyState&, const Environment&, std::span<const double>, std::span<double>,
                Wrench& wrench) const override {
    wrench.force_B.z() += newton_;
  }

 private:
  double newton_;
};

}  // namespace cas::sim::test
