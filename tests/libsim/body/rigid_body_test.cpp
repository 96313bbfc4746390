// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/body/rigid_body.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "tests/libsim/support/four_rotors.hpp"
#include "tests/libsim/support/reference_flight.hpp"

namespace cas::sim {
namespace {

constexpr double kGravity = 9.80665;

Eigen::Matrix3d iris_inertia() {
  Eigen::Matrix3d i;
  i << 0.0300, 0.0004, -0.0007, 0.0004, 0.0295, 0.0003, -0.0007, 0.0003, 0.0565;
  return i;
}

const MassProperties& iris() {
  static const MassProperties mass(1.55, iris_inertia());
  return mass;
}

Environment with_gravity() {
  Environment environment;
  environment.gravity_W = {0, 0, -kGravity};
  return environment;
}

Eigen::Vector3d momentum_W(const BodyState& b) { return b.q_WB * (iris().inertia_B() * b.w_WB_B); }

double energy(const BodyState& b) { return 0.5 * b.w_WB_B.dot(iris().inertia_B() * b.w_WB_B); }

TEST(RigidBody, FreeFallFollowsTheParabola) {
  BodyState body{.v_WB = {3, -2, 5}};
  ForceSet none;
  for (int i = 0; i < 1000; ++i) integrate_free(body, none, iris(), with_gravity(), {}, 1e-3);
  EXPECT_NEAR(body.p_WB.x(), 3.0, 1e-12);
  EXPECT_NEAR(body.p_WB.z(), 5.0 - 0.5 * kGravity, 1e-11);
  EXPECT_NEAR(body.v_WB.z(), 5.0 - kGravity, 1e-11);
}

TEST(RigidBody, TorqueFreeTumblingKeepsEnergyAndMomentum) {
  BodyState body{.w_WB_B = {1.5, 3.0, -2.0}};
  const double energy_0 = energy(body);
  const Eigen::Vector3d momentum_0 = momentum_W(body);
  ForceSet none;
  for (int i = 0; i < 20'000; ++i) integrate_free(body, none, iris(), {}, {}, 1e-3);
  EXPECT_NEAR(energy(body) / energy_0, 1.0, 1e-9);
  EXPECT_LT((momentum_W(body) - momentum_0).norm() / momentum_0.norm(), 1e-9);
  EXPECT_NEAR(body.q_WB.norm(), 1.0, 1e-15);
}

TEST(RigidBody, SymmetricTopPrecessesAsInClosedForm) {
  // Without moments, a body with Ixx = Iyy turns (wx, wy) at the rate (Izz - Ixx) / Ixx * wz.
  const Eigen::Vector3d diagonal(0.03, 0.03, 0.0565);
  const MassProperties top(1.5, diagonal.asDiagonal());
  BodyState body{.w_WB_B = {1.0, 0.0, 4.0}};
  const double rate = (diagonal.z() - diagonal.x()) / diagonal.x() * body.w_WB_B.z();
  ForceSet none;
  for (int i = 0; i < 5000; ++i) integrate_free(body, none, top, {}, {}, 1e-3);
  EXPECT_NEAR(body.w_WB_B.x(), std::cos(rate * 5.0), 1e-8);
  EXPECT_NEAR(body.w_WB_B.y(), std::sin(rate * 5.0), 1e-8);
  EXPECT_NEAR(body.w_WB_B.z(), 4.0, 1e-12);
}

TEST(RigidBody, HeldWrenchAcceleratesByNewtonAndEuler) {
  BodyState body;
  ForceSet none;
  integrate_free(body, none, iris(), {}, {{1.55, 0, 0}, Eigen::Vector3d::Zero()}, 1e-3);
  EXPECT_NEAR(body.v_WB.x(), 1e-3, 1e-15);
  EXPECT_NEAR(body.p_WB.x(), 0.5e-6, 1e-15);
}

// The bound of the project: 1 mm and 0.01 degree after 10 s, at any step from 250 us to 4 ms.
TEST(TumblingFlight, StaysWithAnIndependentSolution) {
  struct StepCase {
    const char* name;
    int step_us;
  };
  const StepCase rows[] = {{"Step250us", 250},
                           {"Step500us", 500},
                           {"Step1ms", 1000},
                           {"Step2ms", 2000},
                           {"Step4ms", 4000}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const test::RotorFigures figures;
    const Eigen::Vector4d command(806, 800, 797, 803);  // thrusting, tumbling about all axes
    BodyState body{.p_WB = {1, 2, 300},
                   .v_WB = {4, -3, 2},
                   .q_WB = Eigen::Quaterniond(0.9, 0.3, -0.2, 0.25).normalized(),
                   .w_WB_B = {1.0, -1.5, 0.5}};

    test::ReferenceFlight reference(iris().mass_kg(), iris_inertia(), figures, command, kGravity);
    reference.start(body);
    test::FourRotors rotors(command, figures);
    ForceSet forces;
    forces.add(rotors);
    forces.reset_states();

    double position_error = 0;
    double angle_error = 0;
    double fastest = 0;
    const int steps_per_part = 20'000 / row.step_us;
    for (int part = 0; part < 500; ++part) {  // parts of 20 ms
      reference.advance(0.02 * part, 0.02);
      for (int i = 0; i < steps_per_part; ++i) {
        integrate_free(body, forces, iris(), with_gravity(), {}, 1e-6 * row.step_us);
      }
      const Eigen::Quaterniond q_reference(reference.rotation());
      position_error = std::max(position_error, (body.p_WB - reference.position()).norm());
      angle_error = std::max(angle_error, body.q_WB.angularDistance(q_reference));
      fastest = std::max(fastest, body.w_WB_B.norm());
    }
    EXPECT_GT(fastest, 3.0) << "it should tumble";
    EXPECT_LT(position_error, 1e-3);
    EXPECT_LT(angle_error, 0.01 * M_PI / 180);
    RecordProperty("position_error_um", static_cast<int>(1e6 * position_error));
    RecordProperty("angle_error_udeg", static_cast<int>(1e6 * angle_error * 180 / M_PI));
  }
}

TEST(ForceSet, RefusesMoreStatesThanItHolds) {
  std::vector<std::unique_ptr<test::FourRotors>> rotors;
  ForceSet forces;
  for (int i = 0; i < 8; ++i) {
    rotors.push_back(std::make_unique<test::FourRotors>(Eigen::Vector4d::Zero()));
    forces.add(*rotors.back());
  }
  test::FourRotors one_more(Eigen::Vector4d::Zero());
  EXPECT_THROW(forces.add(one_more), base::ConfigError);
  EXPECT_TRUE(forces.states_of(one_more).empty());
  EXPECT_EQ(forces.states_of(*rotors[3]).size(), 4u);
}

TEST(ForceSet, IntegratesLagAloneAsInClosedForm) {
  test::FourRotors rotors(Eigen::Vector4d::Constant(500));
  ForceSet forces;
  forces.add(rotors);
  forces.reset_states();
  Wrench mean;
  for (int i = 0; i < 20; ++i) mean = integrate_forces({}, forces, {}, {}, 1e-3);
  EXPECT_NEAR(forces.states_of(rotors)[0], 500 * (1 - std::exp(-1.0)), 1e-4);
  EXPECT_GT(mean.force_B.z(), 0);
}

}  // namespace
}  // namespace cas::sim
