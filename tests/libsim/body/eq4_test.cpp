// SPDX-License-Identifier: BSD-3-Clause
// Where the Newton-Euler equations of the simulator reduce to [HILS] Eq. (4).
#include <gtest/gtest.h>

#include <cmath>

#include "base/config/vehicle.hpp"
#include "base/earth/frames.hpp"
#include "libsim/core/body/rigid_body.hpp"
#include "tests/support/paths.hpp"

namespace cas::sim {
namespace {

constexpr double kG = 9.80665;  // m/s^2
constexpr double kStep = 1e-3;  // s

base::Vehicle iris_vehicle() {
  return base::Vehicle::load(std::filesystem::path(cas::test::source_dir()) /
                             "config/vehicles/iris_paper.yaml");
}

/// Rotors at constant speeds: control inputs by Eq. (3) and the gyroscopic moment.
class SteadyRotors final : public ForceModel {
 public:
  SteadyRotors(const base::Vehicle& vehicle, const Eigen::Vector4d& omega)
      : u_(vehicle.mixing_matrix() * omega.cwiseAbs2()),
        h_(vehicle.rotors[0].params.inertia_kg_m2 * (omega[0] - omega[1] + omega[2] - omega[3])) {}

  int state_count() const override { return 0; }
  void initial_states(std::span<double>) const override {}
  void evaluate(const BodyState& body, const Environment&, std::span<const double>,
                std::span<double>, Wrench& wrench) const override {
    const Eigen::Vector3d w_D = base::swap_BD(body.w_WB_B);
    const Eigen::Vector3d torque_D =
        Eigen::Vector3d(u_[1], u_[2], u_[3]) - w_D.cross(Eigen::Vector3d(0, 0, h_));
    wrench.force_B.z() += u_[0];
    wrench.torque_B += base::swap_BD(torque_D);
  }

  const Eigen::Vector4d& control_inputs() const { return u_; }
  double rotor_momentum() const { return h_; }  ///< J_r omega_r, along z of D

 private:
  Eigen::Vector4d u_;
  double h_;
};

/// Eq. (4), the gyroscopic term of the pitch equation with its sign mended. Angles and rates of D;
/// the translation in axes with z up, x' = north, y' = west, where the equation's signs hold.
struct Eq4 {
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();  // phi, theta, psi
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();

  void advance(const Eigen::Vector4d& u, double j_omega, const base::Vehicle& v, double dt) {
    const Eigen::Vector3d& i = v.inertia_kg_m2;
    const Eigen::Vector3d acceleration(
        (u[1] - j_omega * rate.y() + (i.y() - i.z()) * rate.z() * rate.y()) / i.x(),
        (u[2] + j_omega * rate.x() + (i.z() - i.x()) * rate.x() * rate.z()) / i.y(),
        (u[3] + (i.x() - i.y()) * rate.y() * rate.x()) / i.z());
    // Angles of axes with z up: roll as in D, pitch and yaw the other way.
    const double phi = angle.x();
    const double theta = -angle.y();
    const double psi = -angle.z();
    const Eigen::Vector3d thrust_axis(
        std::cos(phi) * std::cos(psi) * std::sin(theta) + std::sin(phi) * std::sin(psi),
        std::cos(phi) * std::sin(psi) * std::sin(theta) - std::sin(phi) * std::cos(psi),
        std::cos(phi) * std::cos(theta));
    const Eigen::Vector3d a = u[0] / v.mass_kg * thrust_axis - Eigen::Vector3d(0, 0, kG);
    position += dt * velocity + 0.5 * dt * dt * a;
    velocity += dt * a;
    angle += dt * rate + 0.5 * dt * dt * acceleration;
    rate += dt * acceleration;
  }
};

TEST(Eq4, IsTheSmallAngleReadingOfNewtonEuler) {
  const base::Vehicle vehicle = iris_vehicle();
  const double hover =
      std::sqrt(vehicle.mass_kg * kG / (4 * vehicle.rotors[0].params.thrust_coefficient));
  // A little of each moment.
  const Eigen::Vector4d omega = Eigen::Vector4d(hover + 2.4, hover - 1.0, hover + 0.4, hover - 2.0);
  const SteadyRotors rotors(vehicle, omega);
  ForceSet forces;
  forces.add(rotors);
  const MassProperties mass(vehicle.mass_kg, vehicle.inertia_kg_m2.asDiagonal());
  Environment environment;
  environment.gravity_W = {0, 0, -kG};

  BodyState body;
  body.q_WB = base::q_WB_from_q_ND(Eigen::Quaterniond::Identity());  // facing north
  Eq4 eq4;
  constexpr int kParts = 100;  // of Eq. (4)'s simple integration per step
  for (int step = 0; step < 1000; ++step) {
    integrate_free(body, forces, mass, environment, {}, kStep);
    for (int part = 0; part < kParts; ++part) {
      eq4.advance(rotors.control_inputs(), rotors.rotor_momentum(), vehicle, kStep / kParts);
    }
  }
  const Eigen::Vector3d rpy = base::euler_rpy(base::q_ND_from_q_WB(body.q_WB));
  ASSERT_GT(rpy.cwiseAbs().maxCoeff(), 0.01) << "it should have turned";
  ASSERT_LT(rpy.cwiseAbs().maxCoeff(), 0.1) << "the angles should be small";
  // Euler rates are body rates but for products of angles and rates.
  EXPECT_LT((rpy - eq4.angle).norm(), rpy.squaredNorm());
  const Eigen::Vector3d position_NWU(body.p_WB.y(), -body.p_WB.x(), body.p_WB.z());
  EXPECT_LT((position_NWU - eq4.position).norm(), 1e-3);
}

TEST(Eq4, PitchTermAsPrintedWouldMakeEnergyFromNothing) {
  // Torque-free but for the rotors' momentum: -w x h does no work. With the printed sign of the
  // pitch equation rotational energy grows; the simulator keeps it.
  const base::Vehicle vehicle = iris_vehicle();
  const Eigen::Vector3d& i = vehicle.inertia_kg_m2;
  const double j_omega = vehicle.rotors[0].params.inertia_kg_m2 * 400;
  const auto energy = [&](const Eigen::Vector3d& w) { return 0.5 * w.dot(i.cwiseProduct(w)); };
  const auto advance = [&](Eigen::Vector3d w, double pitch_sign) {
    for (int step = 0; step < 100000; ++step) {
      const double dt = 1e-4;
      const Eigen::Vector3d a(
          (-j_omega * w.y() + (i.y() - i.z()) * w.y() * w.z()) / i.x(),
          (pitch_sign * j_omega * w.x() + (i.z() - i.x()) * w.x() * w.z()) / i.y(), 0);
      const Eigen::Vector3d middle = w + 0.5 * dt * a;
      const Eigen::Vector3d b(
          (-j_omega * middle.y() + (i.y() - i.z()) * middle.y() * middle.z()) / i.x(),
          (pitch_sign * j_omega * middle.x() + (i.z() - i.x()) * middle.x() * middle.z()) / i.y(),
          0);
      w += dt * b;
    }
    return w;
  };
  const Eigen::Vector3d start(0.5, 0.3, 0);
  EXPECT_GT(energy(advance(start, -1)), 2 * energy(start));
  EXPECT_NEAR(energy(advance(start, 1)) / energy(start), 1, 1e-6);
}

}  // namespace
}  // namespace cas::sim
