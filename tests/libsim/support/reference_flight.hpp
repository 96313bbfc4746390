// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "tests/libsim/support/four_rotors.hpp"

namespace cas::sim::test {

/// An independent solution of the quadrotor's motion, sharing neither formulation nor method with
/// the code under test: angular momentum of body and rotors in W, attitude as a rotation matrix,
/// rotor speeds in closed form, integrated by Gragg-Bulirsch-Stoer extrapolation of order 16.
class ReferenceFlight {
 public:
  ReferenceFlight(double mass, const Eigen::Matrix3d& inertia, const RotorFigures& figures,
                  const Eigen::Vector4d& command, double gravity)
      : mass_(mass), inertia_(inertia), f_(figures), command_(command), gravity_(gravity) {}

  void start(const BodyState& body) {
    const Eigen::Matrix3d R = body.q_WB.toRotationMatrix();
    y_.segment<3>(0) = body.p_WB;
    y_.segment<3>(3) = body.v_WB;
    y_.segment<3>(6) = R * (inertia_ * body.w_WB_B + rotor_momentum(0));
    y_.segment<9>(9) = R.reshaped();
  }

  void advance(double t0, double dt) {
    constexpr int kOrders = 8;
    std::vector<State> table(kOrders);
    for (int k = 0; k < kOrders; ++k) {
      const int n = 2 * (k + 1);
      table[static_cast<std::size_t>(k)] = midpoint(t0, dt, n);
      for (int j = k - 1; j >= 0; --j) {
        const double ratio = static_cast<double>(n) / (2 * (j + 1));
        State& coarse = table[static_cast<std::size_t>(j)];
        const State& fine = table[static_cast<std::size_t>(j + 1)];
        coarse = fine + (fine - coarse) / (ratio * ratio - 1);
      }
    }
    y_ = table[0];
  }

  Eigen::Vector3d position() const { return y_.segment<3>(0); }
  Eigen::Vector3d velocity() const { return y_.segment<3>(3); }
  Eigen::Matrix3d rotation() const { return y_.segment<9>(9).reshaped(3, 3); }

 private:
  using State = Eigen::Matrix<double, 18, 1>;

  double speed(std::size_t rotor, double t) const {
    return command_[static_cast<Eigen::Index>(rotor)] * (1 - std::exp(-t / f_.time_constant));
  }

  Eigen::Vector3d rotor_momentum(double t) const {
    Eigen::Vector3d h = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 4; ++i) h.z() += f_.inertia * f_.spin[i] * speed(i, t);
    return h;
  }

  State slope(double t, const State& y) const {
    const Eigen::Matrix3d R = y.segment<9>(9).reshaped(3, 3);
    const Eigen::Vector3d h_B = R.inverse() * Eigen::Vector3d(y.segment<3>(6));
    const Eigen::Vector3d w = inertia_.ldlt().solve(h_B - rotor_momentum(t));
    Eigen::Vector3d force_B = Eigen::Vector3d::Zero();
    Eigen::Vector3d torque_B = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 4; ++i) {
      const double s = speed(i, t);
      const Eigen::Vector3d thrust(0, 0, f_.thrust * s * s);
      force_B += thrust;
      torque_B +=
          f_.position_B[i].cross(thrust) - Eigen::Vector3d(0, 0, f_.spin[i] * f_.torque * s * s);
    }
    Eigen::Matrix3d w_cross;
    w_cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
    State dy;
    dy.segment<3>(0) = y.segment<3>(3);
    dy.segment<3>(3) = R * force_B / mass_ - Eigen::Vector3d(0, 0, gravity_);
    dy.segment<3>(6) = R * torque_B;
    dy.segment<9>(9) = Eigen::Matrix3d(R * w_cross).reshaped();
    return dy;
  }

  /// Gragg's modified midpoint rule with n parts.
  State midpoint(double t0, double dt, int n) const {
    const double h = dt / n;
    State before = y_;
    State at = y_ + h * slope(t0, y_);
    for (int i = 1; i < n; ++i) {
      const State next = before + 2 * h * slope(t0 + i * h, at);
      before = at;
      at = next;
    }
    return 0.5 * (at + before + h * slope(t0 + dt, at));
  }

  double mass_;
  Eigen::Matrix3d inertia_;
  RotorFigures f_;
  Eigen::Vector4d command_;
  double gravity_;
  State y_;
};

}  // namespace cas::sim::test
