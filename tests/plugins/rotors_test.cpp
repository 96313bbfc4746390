// SPDX-License-Identifier: BSD-3-Clause
// Vehicles of 1 to 16 rotors with any axis, coaxial pairs and tilting servos, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "base/config/frame_table.hpp"
#include "libsim/core/body/rigid_body.hpp"
#include "plugins/motor/motor_mixer.hpp"
#include "plugins/motor/rotor_model.hpp"
#include "tests/plugins/plugin_harness.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using test::load_vehicle;

constexpr double kRounding = 1e-12;  // of sums of a few products near 1

base::Rotor simple_rotor() {
  base::Rotor rotor;
  rotor.params = {.thrust_coefficient = 1e-5,
                  .torque_coefficient = 2e-7,
                  .omega_max_rad_s = 1000,
                  .omega_idle_rad_s = 100,
                  .time_constant_up_s = 0.02,
                  .time_constant_down_s = 0.04,
                  .inertia_kg_m2 = 3e-5,
                  .radius_m = 0.1};
  return rotor;
}

base::Vehicle vehicle_of(std::vector<base::Rotor> rotors) {
  base::Vehicle vehicle;
  vehicle.mass_kg = 1;
  vehicle.rotors = std::move(rotors);
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    vehicle.rotors[i].output = static_cast<int>(i);
  }
  return vehicle;
}

struct Answer {
  Wrench wrench;
  std::vector<double> x_dot;
};

Answer answer_of(const RotorModel& model, const std::vector<double>& x, const BodyState& body = {},
                 const Environment& air = {}) {
  Answer answer;
  answer.x_dot.resize(x.size());
  model.evaluate(body, air, x, answer.x_dot, answer.wrench);
  return answer;
}

/// Rotors with random places, axes, spins, coefficients and tilts; each second one in a wake.
base::Vehicle random_vehicle(int count, std::mt19937& engine) {
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<base::Rotor> rotors;
  for (int i = 0; i < count; ++i) {
    base::Rotor rotor = simple_rotor();
    rotor.position_B_m = Vector3d(number(engine), number(engine), number(engine));
    rotor.axis_B = Vector3d(number(engine), number(engine), 1.2 + number(engine)).normalized();
    rotor.spin = number(engine) > 0 ? 1 : -1;
    rotor.params.thrust_coefficient *= 1.5 + number(engine);
    rotor.params.torque_coefficient *= 1.5 + number(engine);
    if (i % 2 == 1) rotor.wake = {.upper = i - 1, .thrust_share = 0.7};
    if (i % 3 == 0) {
      rotor.tilt = base::TiltServo{.axis_B = Vector3d(number(engine), 1, 0).normalized(),
                                   .min_rad = -1,
                                   .max_rad = 1,
                                   .rate_rad_s = 10,
                                   .time_constant_s = 0.05,
                                   .output = 15};
    }
    rotors.push_back(rotor);
  }
  return vehicle_of(std::move(rotors));
}

TEST(Rotors, GiveWhatTheEffectivenessMatrixSays) {
  std::mt19937 engine(1);
  for (int count = 1; count <= base::kMaxRotors; ++count) {
    const base::Vehicle vehicle = random_vehicle(count, engine);
    RotorModel model(vehicle);
    const double omega = 500;  // of all: coaxial pairs turn equally fast
    std::vector<double> x(static_cast<std::size_t>(model.state_count()), omega);
    std::vector<double> tilt(static_cast<std::size_t>(count), 0.0);
    std::size_t state = static_cast<std::size_t>(count);
    for (std::size_t i = 0; i < tilt.size(); ++i) {
      if (vehicle.rotors[i].tilt) x[state++] = tilt[i] = 0.1 * static_cast<double>(i) - 0.3;
    }
    model.set_targets(base::RotorVector::Constant(count, omega));
    base::RotorVector held(count);
    for (int i = 0; i < count; ++i) held[i] = tilt[static_cast<std::size_t>(i)];
    model.set_tilt_targets(held);
    const Wrench wrench = answer_of(model, x).wrench;
    const Eigen::Matrix<double, 6, 1> expected =
        vehicle.effectiveness(tilt) * base::RotorVector::Constant(count, omega * omega);
    EXPECT_TRUE(wrench.force_B.isApprox(expected.head<3>(), kRounding)) << count;
    EXPECT_TRUE(wrench.torque_B.isApprox(expected.tail<3>(), kRounding)) << count;
  }
}

TEST(Rotors, UprightOnesTakeTheShortWayToTheSameWrench) {
  // An axis that leans by less than a rounding error sends a whole vehicle the long way.
  base::Vehicle vehicle = load_vehicle("iris_px4");
  const RotorModel upright(vehicle);
  vehicle.rotors[0].axis_B = Vector3d(1e-17, 0, 1);
  const RotorModel any(vehicle);
  BodyState body{.v_WB = {3, -2, 1},
                 .q_WB = Eigen::Quaterniond(0.9, 0.1, -0.2, 0.3).normalized(),
                 .w_WB_B = {0.5, -0.3, 0.7}};
  const std::vector<double> x{700, 720, 690, 710};
  const Wrench a = answer_of(upright, x, body).wrench;
  const Wrench b = answer_of(any, x, body).wrench;
  EXPECT_TRUE(a.force_B.isApprox(b.force_B, kRounding));
  EXPECT_TRUE(a.torque_B.isApprox(b.torque_B, kRounding));
}

TEST(Rotors, ATiltedHexarotorPushesSideways) {
  // Each arm's axis leans by 20 deg about the arm, the sense alternates: all six axes of motion.
  std::vector<base::Rotor> rotors;
  for (int i = 0; i < 6; ++i) {
    const double arm = i * M_PI / 3;
    base::Rotor rotor = simple_rotor();
    rotor.position_B_m = 0.3 * Vector3d(std::cos(arm), std::sin(arm), 0);
    const double lean = (i % 2 == 0 ? 1 : -1) * 20 * M_PI / 180;
    rotor.axis_B = Eigen::AngleAxisd(lean, rotor.position_B_m.normalized()) * Vector3d::UnitZ();
    rotor.spin = i % 2 == 0 ? 1 : -1;
    rotors.push_back(rotor);
  }
  const base::Vehicle vehicle = vehicle_of(std::move(rotors));
  const Eigen::Matrix<double, 6, 6> all = vehicle.effectiveness();
  // Omega^2 for the weight and a push of 1 N to the left, without any moment.
  Eigen::Matrix<double, 6, 1> wanted;
  wanted << 0, 1, 9.80665, 0, 0, 0;
  const Eigen::Matrix<double, 6, 1> omega_sq = all.fullPivLu().solve(wanted);
  ASSERT_GT(omega_sq.minCoeff(), 0);
  std::vector<double> x(6);
  for (int i = 0; i < 6; ++i) x[static_cast<std::size_t>(i)] = std::sqrt(omega_sq[i]);
  RotorModel model(vehicle);
  model.set_targets(base::RotorVector::Map(x.data(), 6));
  const Wrench wrench = answer_of(model, x).wrench;
  constexpr double kSolved = 1e-9;  // by the linear solver
  EXPECT_TRUE(wrench.force_B.isApprox(Vector3d(0, 1, 9.80665), kSolved));
  EXPECT_LT(wrench.torque_B.norm(), kSolved);
}

TEST(Rotors, AGyroscopeTurnsAboutItsOwnAxis) {
  base::Rotor rotor = simple_rotor();
  rotor.params.thrust_coefficient = rotor.params.torque_coefficient = 0;
  rotor.axis_B = Vector3d(0.6, 0, 0.8);
  RotorModel model(vehicle_of({rotor}));
  model.set_targets(base::RotorVector::Constant(1, 600));
  BodyState body{.w_WB_B = {2, 3, 1}};
  // t = -w x H - J w_dot a, with H = J w a and w_dot = (600 - 500) / 0.02 s.
  const Vector3d momentum = 3e-5 * 500 * rotor.axis_B;
  const Vector3d expected = -body.w_WB_B.cross(momentum) - 3e-5 * 100 / 0.02 * rotor.axis_B;
  EXPECT_TRUE(answer_of(model, {500}, body).wrench.torque_B.isApprox(expected, kRounding));
}

TEST(Rotors, DragLiesInTheRotorsOwnPlaneAndThrustFadesAlongItsAxis) {
  base::Rotor rotor = simple_rotor();
  rotor.params.drag_coefficient = 1e-4;
  rotor.params.zero_thrust_speed_m_s = 20;
  rotor.axis_B = Vector3d(0, -0.6, 0.8);
  const RotorModel model(vehicle_of({rotor}));
  BodyState body;
  body.v_WB = 5 * rotor.axis_B + Vector3d(2, 0, 0);  // 5 m/s along the axis, 2 m/s across it
  const double thrust = 1e-5 * 500 * 500 * (1 - 5.0 / 20);
  const Vector3d expected = thrust * rotor.axis_B - 1e-4 * 500 * Vector3d(2, 0, 0);
  EXPECT_TRUE(answer_of(model, {500}, body).wrench.force_B.isApprox(expected, kRounding));
}

TEST(Rotors, ThrustAndTorqueFollowTheInflow) {
  base::Rotor rotor = simple_rotor();
  rotor.params.inertia_kg_m2 = 0;
  rotor.params.inflow_thrust_slope = 0.7;
  rotor.params.reversible = true;
  rotor.axis_B = Vector3d(0, -0.6, 0.8);
  const RotorModel model(vehicle_of({rotor}));
  Environment air;
  air.air_density_kg_m3 = 1.2;
  const Vector3d across_B(0, 0.8, 0.6);
  for (const double omega : {500.0, -500.0}) {
    for (const double climb : {-3.0, -0.5, 0.0, 4.0}) {  // m/s
      BodyState body{.v_WB = climb * rotor.axis_B + 6 * across_B};
      const double sign = std::copysign(1.0, omega);
      const RotorLoad load = rotor_load({.slope = 0.7,
                                         .radius_m = 0.1,
                                         .omega_rad_s = 500,
                                         .density_kg_m3 = 1.2,
                                         .hover_thrust_n = 1e-5 * 500 * 500,
                                         .hover_torque_n_m = 2e-7 * 500 * 500,
                                         .climb_m_s = sign * climb,
                                         .edgewise_m_s = 6});
      const Answer answer = answer_of(model, {omega}, body, air);
      EXPECT_TRUE(answer.wrench.force_B.isApprox(sign * 2.5 * load.thrust * rotor.axis_B, 1e-9));
      EXPECT_TRUE(answer.wrench.torque_B.isApprox(-sign * 0.05 * load.torque * rotor.axis_B, 1e-9));
      EXPECT_NEAR(model.shaft_powers(body, air, std::vector{omega})[0],
                  std::max(0.0, 500 * 0.05 * load.torque), 1e-9);
    }
  }
}

TEST(Rotors, WithBrokenBladesOrWithoutAirHaveAFiniteInflow) {
  base::Rotor rotor = simple_rotor();
  rotor.params.inertia_kg_m2 = 0;
  rotor.params.inflow_thrust_slope = 0.7;
  RotorModel model(vehicle_of({rotor}));
  Environment air;
  air.air_density_kg_m3 = 1.2;
  BodyState body{.v_WB = {8, 0, 2}};
  const auto thrust = [&](double share) {
    model.set_effectiveness(base::RotorVector::Constant(1, share));
    const Wrench wrench = answer_of(model, {500}, body, air).wrench;
    EXPECT_TRUE(wrench.force_B.allFinite() && wrench.torque_B.allFinite()) << share;
    return wrench.force_B.z();
  };
  EXPECT_EQ(thrust(0), 0);
  EXPECT_GT(thrust(0.5), 0);
  body.v_WB.z() = -2;
  const double up = thrust(0.5);
  body.v_WB.z() = 2;
  EXPECT_NEAR(thrust(-0.5), -up, 1e-9) << "it pulls the other way";
  air.air_density_kg_m3 = 0;
  EXPECT_NEAR(thrust(1), 2.5, 1e-9) << "k_f holds in any air";
}

TEST(Rotors, ThatComeToRestInAWindLoseTheirThrustWithTheSquareOfTheirSpeed) {
  base::Rotor rotor = simple_rotor();
  rotor.params.inflow_thrust_slope = 0.7;
  const RotorModel model(vehicle_of({rotor}));
  Environment air;
  air.air_density_kg_m3 = 1.2;
  BodyState body{.v_WB = {8, 0, -4}};
  const auto per_square = [&](double omega) {
    const Wrench wrench = answer_of(model, {omega}, body, air).wrench;
    EXPECT_TRUE(wrench.force_B.allFinite() && wrench.torque_B.allFinite()) << omega;
    return wrench.force_B.z() / (omega * omega);
  };
  EXPECT_NEAR(per_square(1) / per_square(0.1), 1, 1e-3);
  EXPECT_LT(per_square(1e-3), 1e-3);  // N s^2; the still rotor's is 1e-5
  for (double omega = 1; omega > 1e-200; omega *= 1e-3) per_square(omega);
  const Wrench still = answer_of(model, {0}, body, air).wrench;
  EXPECT_TRUE(still.force_B.isZero(0) && still.torque_B.isZero(0));
}

/// Swings on a spring through hover, climb and sink, leaning.
class Spring final : public ForceModel {
 public:
  int state_count() const override { return 0; }
  void initial_states(std::span<double>) const override {}
  void evaluate(const BodyState& body, const Environment&, std::span<const double>,
                std::span<double>, Wrench& wrench) const override {
    wrench.force_B -= body.q_WB.conjugate() * (20.0 * body.p_WB);
  }
};

Vector3d place_after_ten_seconds(const RotorModel& model, double dt) {
  const Spring spring;
  ForceSet forces;
  forces.add(model);
  forces.add(spring);
  BodyState body{.v_WB = {2, 0, 3}};
  body.q_WB = Eigen::AngleAxisd(0.1, Vector3d::UnitY());
  Environment air;
  air.gravity_W = {0, 0, -9.80665};
  air.air_density_kg_m3 = 1.225;
  air.height_above_ground_m = 100;
  const MassProperties mass(1, Vector3d(0.03, 0.03, 0.056).asDiagonal());
  for (int i = 0; i < std::lround(10 / dt); ++i) integrate_free(body, forces, mass, air, {}, dt);
  return body.p_WB;
}

base::Vehicle four_rotors(double base::RotorParams::*member, double value) {
  std::vector<base::Rotor> rotors;
  for (const double side : {-0.2, 0.2}) {
    for (const double end : {-0.2, 0.2}) {
      base::Rotor rotor = simple_rotor();
      rotor.position_B_m = {end, side, 0.02};
      rotor.spin = side * end > 0 ? 1 : -1;
      rotor.params.*member = value;
      rotors.push_back(rotor);
    }
  }
  return vehicle_of(std::move(rotors));
}

TEST(Rotors, InWindAreIntegratedToAMicrometre) {
  RotorModel model(four_rotors(&base::RotorParams::inflow_thrust_slope, 0.7));
  model.set_targets(base::RotorVector::Constant(4, 495));  // 9.8 N
  EXPECT_LT((place_after_ten_seconds(model, 1e-3) - place_after_ten_seconds(model, 1e-4)).norm(),
            1e-6);
}

TEST(Rotors, WhoseThrustFadesAreIntegratedToAMicrometre) {
  RotorModel model(four_rotors(&base::RotorParams::zero_thrust_speed_m_s, 25));
  model.set_targets(base::RotorVector::Constant(4, 520));
  EXPECT_LT((place_after_ten_seconds(model, 1e-3) - place_after_ten_seconds(model, 5e-4)).norm(),
            1e-6);
}

/// Hoffmann et al.: the disc tilts back, a stiff hub lifts the nose by K a, a = A v / (w R).
TEST(Rotors, AStiffHubPassesFlappingOn) {
  base::Rotor rotor = simple_rotor();
  rotor.params.thrust_coefficient = rotor.params.torque_coefficient = 0;
  rotor.params.inertia_kg_m2 = 0;
  rotor.params.flapping_gain = 0.4;
  rotor.params.flapping_stiffness_nm_rad = 0.25;
  const RotorModel model(vehicle_of({rotor}));
  BodyState body{.v_WB = {6, 0, 2}};
  const auto moment = [&](double omega) { return answer_of(model, {omega}, body).wrench.torque_B; };
  // Nose up is about -By. The tips are at 50 m/s; no part of it comes of climbing.
  EXPECT_TRUE(moment(500).isApprox(Vector3d(0, -0.25 * 0.4 * 6 / 50, 0), kRounding));
  EXPECT_TRUE(moment(60).isApprox(Vector3d(0, -0.25 * 0.4, 0), kRounding)) << "advance ratio 1";
  EXPECT_TRUE(moment(30).isApprox(Vector3d(0, -0.25 * 0.4 / 2, 0), kRounding)) << "it fades";
  EXPECT_TRUE(moment(0).isZero(0)) << "wind past one that stands";
  body.v_WB.setZero();
  EXPECT_TRUE(moment(0).isZero(0));
}

TEST(CoaxialPair, TheLowerRotorLosesThrustToTheUpper) {
  base::Rotor upper = simple_rotor();
  base::Rotor lower = simple_rotor();
  lower.spin = -1;
  lower.wake = {.upper = 0, .thrust_share = 0.7};
  RotorModel model(vehicle_of({upper, lower}));
  const auto thrust = [&](double upper_omega, double lower_omega) {
    return answer_of(model, {upper_omega, lower_omega}).wrench.force_B.z();
  };
  const double one = 1e-5 * 500 * 500;
  EXPECT_NEAR(thrust(500, 500), 1.7 * one, kRounding);
  EXPECT_NEAR(thrust(0, 500), one, kRounding) << "no wake from one that stands";
  EXPECT_NEAR(thrust(500, 0), one, kRounding);
  // k w (w - 0.3 w_upper)
  EXPECT_NEAR(thrust(400, 500) - 1e-5 * 400 * 400, 1e-5 * 500 * (500 - 0.3 * 400), kRounding);
  EXPECT_NEAR(thrust(1000, 200), 1e-5 * 1000 * 1000, kRounding) << "it does not pull downwards";
  EXPECT_NEAR(answer_of(model, {500, 500}).wrench.torque_B.z(), 0, kRounding);
  model.set_effectiveness(Eigen::Vector2d(0, 1));
  EXPECT_NEAR(thrust(500, 500), one, kRounding) << "no wake from one without blades";
  model.set_effectiveness(Eigen::Vector2d(1, 1));
  model.stop(0);
  EXPECT_NEAR(thrust(500, 500), one, kRounding);
}

base::Vehicle tail_rotor() {
  base::Rotor rotor = simple_rotor();
  rotor.position_B_m = {-0.3, 0, 0};
  rotor.tilt = base::TiltServo{.axis_B = Vector3d::UnitX(),
                               .min_rad = -0.8,
                               .max_rad = 0.5,
                               .rate_rad_s = 5,
                               .time_constant_s = 0.05,
                               .output = 3};
  return vehicle_of({rotor});
}

TEST(TiltServo, TurnsTheThrustOfATricoptersTail) {
  RotorModel model(tail_rotor());
  model.set_targets(base::RotorVector::Constant(1, 500));
  model.set_tilt_targets(base::RotorVector::Constant(1, 0.2));
  const Wrench wrench = answer_of(model, {500, 0.2}).wrench;
  const double thrust = 1e-5 * 500 * 500;
  const double torque = 2e-7 * 500 * 500;
  // Up turns to the right (-y) about the nose; behind the centre that yaws the nose to the left.
  EXPECT_TRUE(
      wrench.force_B.isApprox(thrust * Vector3d(0, -std::sin(0.2), std::cos(0.2)), kRounding));
  EXPECT_NEAR(wrench.torque_B.z(), 0.3 * thrust * std::sin(0.2) - torque * std::cos(0.2),
              kRounding);
}

TEST(TiltServo, TurnsTheRotorsMomentumWithIt) {
  base::Vehicle vehicle = tail_rotor();
  vehicle.rotors[0].params.thrust_coefficient = vehicle.rotors[0].params.torque_coefficient = 0;
  RotorModel model(vehicle);
  model.set_targets(base::RotorVector::Constant(1, 500));
  model.set_tilt_targets(base::RotorVector::Constant(1, 0.1));
  // 0.1 rad over 0.05 s is 2 rad/s; t = -J w d(axis)/dt with d(axis)/dt = 2 x * z = -2 y.
  const Wrench wrench = answer_of(model, {500, 0.0}).wrench;
  EXPECT_TRUE(wrench.torque_B.isApprox(Vector3d(0, 2 * 3e-5 * 500, 0), kRounding));
}

TEST(TiltServo, LagsAndIsNoFasterThanItsRate) {
  RotorModel model(tail_rotor());
  model.set_tilt_targets(base::RotorVector::Constant(1, 0.1));
  EXPECT_NEAR(answer_of(model, {0, 0.0}).x_dot[1], 0.1 / 0.05, kRounding);
  model.set_tilt_targets(base::RotorVector::Constant(1, 0.5));
  EXPECT_NEAR(answer_of(model, {0, 0.0}).x_dot[1], 5, kRounding);

  // 5 rad/s until 0.25 rad are left, then exp(-t / 0.05 s).
  double tilt = 0;
  const auto run = [&](double seconds) {
    constexpr double kStep_s = 1e-4;
    for (int i = 0; i < std::lround(seconds / kStep_s); ++i) {
      const double middle = tilt + 0.5 * kStep_s * answer_of(model, {0, tilt}).x_dot[1];
      tilt += kStep_s * answer_of(model, {0, middle}).x_dot[1];
    }
    return tilt;
  };
  constexpr double kMidpoint =
      1e-6;  // rad: the rule's error, and the corner that falls within a step
  EXPECT_NEAR(run(0.05), 0.25, kMidpoint);
  EXPECT_NEAR(run(0.05), 0.5 - 0.25 * std::exp(-1), kMidpoint);
}

/// A front rotor of a tiltrotor: upright at output -1, forwards at +1.
base::Vehicle tilting_rotor() {
  base::Rotor rotor = simple_rotor();
  rotor.position_B_m = {0.35, -0.3, 0.07};
  rotor.tilt = base::TiltServo{.axis_B = Vector3d::UnitY(),
                               .max_rad = M_PI / 2,
                               .middle_rad = M_PI / 4,
                               .rate_rad_s = 3,
                               .time_constant_s = 0.05,
                               .output = 4};
  return vehicle_of({rotor});
}

TEST(TiltServo, TurnsATiltrotorsThrustForwards) {
  RotorModel model(tilting_rotor());
  model.set_targets(base::RotorVector::Constant(1, 500));
  const double thrust = 1e-5 * 500 * 500;
  const double torque = 2e-7 * 500 * 500;
  for (const double tilt : {0.0, 0.3, M_PI / 4, M_PI / 2}) {
    model.set_tilt_targets(base::RotorVector::Constant(1, tilt));
    const Wrench wrench = answer_of(model, {500, tilt}).wrench;
    const double ahead = thrust * std::sin(tilt);
    const double up = thrust * std::cos(tilt);
    EXPECT_TRUE(wrench.force_B.isApprox(Vector3d(ahead, 0, up), kRounding)) << tilt;
    // Arm times force, less the reaction to the drag of a counter-clockwise rotor.
    const Vector3d moment_B(-0.3 * up - torque * std::sin(tilt), 0.07 * ahead - 0.35 * up,
                            0.3 * ahead - torque * std::cos(tilt));
    EXPECT_TRUE(wrench.torque_B.isApprox(moment_B, kRounding)) << tilt;
  }
}

/// The air that takes thrust is that along the axis: none in forward flight when it stands upright.
TEST(TiltServo, TurnsTheAirThatTakesTheThrust) {
  base::Vehicle vehicle = tilting_rotor();
  vehicle.rotors[0].params.zero_thrust_speed_m_s = 25;
  RotorModel model(vehicle);
  model.set_targets(base::RotorVector::Constant(1, 500));
  BodyState body{.v_WB = {10, 0, 0}};
  const double thrust = 1e-5 * 500 * 500;
  for (const double tilt : {0.0, 0.5, M_PI / 2}) {
    model.set_tilt_targets(base::RotorVector::Constant(1, tilt));
    const Wrench wrench = answer_of(model, {500, tilt}, body).wrench;
    EXPECT_NEAR(wrench.force_B.norm(), thrust * (1 - 10 * std::sin(tilt) / 25), kRounding) << tilt;
  }
}

TEST(MotorMixer, TiltsARotorAboutTheMiddleOfItsServo) {
  const MotorMixer mixer(tilting_rotor());
  MotorCommand command;
  command.kind = MotorCommand::Kind::kMotorOutputs;
  command.armed = true;
  command.values.setZero(16);
  for (const auto& [output, tilt] :
       {std::pair(-1.0, 0.0), std::pair(-0.5, M_PI / 8), std::pair(0.0, M_PI / 4),
        std::pair(1.0, M_PI / 2), std::pair(1.3, M_PI / 2)}) {
    command.values[4] = output;
    EXPECT_NEAR(mixer.tilts(command)[0], tilt, kRounding) << output;
  }
  command.armed = false;
  EXPECT_EQ(mixer.tilts(command)[0], 0) << "upright";
}

TEST(MotorMixer, TakesEachRotorsOutputAndRange) {
  base::Vehicle vehicle = tail_rotor();
  base::Rotor other = simple_rotor();
  other.params.omega_max_rad_s = 600;
  other.output = 8;
  vehicle.rotors.push_back(other);
  const MotorMixer mixer(vehicle);
  MotorCommand command;
  command.kind = MotorCommand::Kind::kMotorOutputs;
  command.armed = true;
  command.values.setZero(16);
  command.values[0] = 0.5;
  command.values[3] = -0.5;  // servo
  command.values[8] = 1;
  EXPECT_TRUE(mixer.targets(command).isApprox(Eigen::Vector2d(550, 600), kRounding));
  EXPECT_TRUE(mixer.tilts(command).isApprox(Eigen::Vector2d(-0.4, 0), kRounding));
  command.values[3] = 2;
  EXPECT_NEAR(mixer.tilts(command)[0], 0.5, kRounding);
  command.armed = false;
  EXPECT_TRUE(mixer.targets(command).isZero(0));
  EXPECT_TRUE(mixer.tilts(command).isZero(0));
}

TEST(MotorMixer, ControlInputsOfAHexarotorGoThroughThePseudoInverse) {
  const base::Vehicle vehicle = load_vehicle("hexa_x");
  const MotorMixer mixer(vehicle);
  MotorCommand command;
  command.armed = true;
  command.values = Eigen::Vector4d(24.0, 0.3, -0.2, 0.05);
  const base::RotorVector omega = mixer.targets(command);
  ASSERT_EQ(omega.size(), 6);
  const Eigen::Matrix<double, 6, 1> wrench = vehicle.effectiveness() * omega.cwiseAbs2();
  constexpr double kSolved = 1e-9;
  EXPECT_NEAR(wrench[2], 24.0, kSolved);
  EXPECT_NEAR(wrench[3], 0.3, kSolved);
  EXPECT_NEAR(wrench[4], 0.2, kSolved);    // U3 is about Dy = -By
  EXPECT_NEAR(wrench[5], -0.05, kSolved);  // U4 about Dz = -Bz
}

TEST(MotorPlugin, DrivesTheSixthRotorFromTheSixthOutput) {
  test::PluginHarness harness(std::chrono::milliseconds(1), ".", "hexa_x");
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("motor", "{}");
  MotorCommand outputs;
  outputs.kind = MotorCommand::Kind::kMotorOutputs;
  outputs.armed = true;
  outputs.values.setZero(16);
  outputs.values[5] = 1;
  command.publish(outputs);
  std::vector<double> x(6, 0.0);
  std::vector<double> x_dot(6);
  Wrench wrench;
  harness.context.force_models[0]->evaluate({}, {}, x, x_dot, wrench);
  EXPECT_NEAR(x_dot[5], 850 / 0.02, 1e-6);
  EXPECT_NEAR(x_dot[0], 100 / 0.02, 1e-6) << "armed, the others idle";
}

TEST(MotorPlugin, ATiltedDiscStrikesWhereItsServoHoldsIt) {
  test::PluginHarness harness(std::chrono::milliseconds(1), ".", "tri");
  const Plugin& motor = harness.add("motor", "{}");
  auto& states = harness.world.model_states.at(harness.context.force_models[0]);
  states = {500, 500, 500, 0.3};
  harness.world.touched_disc_B = harness.context.vehicle().rotors[2].position_B_m;
  harness.step();
  EXPECT_EQ(motor.stats_json(), "") << "upright, the tail's disc would touch";
  harness.world.disc_axis_B = {0, -std::sin(0.3), std::cos(0.3)};
  harness.step();
  EXPECT_NE(motor.stats_json().find("\"rotor\":3"), std::string::npos);
}

/// The figures of PX4-gazebo-models, models/x500, put into gz-sim's MulticopterMotorModel.
TEST(X500, GivesWhatGazebosMotorModelGives) {
  const RotorModel model(load_vehicle("x500"));
  const std::vector<double> x(4, 769.0);
  BodyState body{.v_WB = {3, 0, 5}};
  Environment air;
  air.air_density_kg_m3 = 1.0;
  const Wrench wrench = answer_of(model, x, body, air).wrench;
  EXPECT_NEAR(wrench.force_B.z(), 4 * 8.54858e-06 * 769 * 769, 1e-9) << "thrust does not fade";
  EXPECT_NEAR(wrench.force_B.x(), -4 * 769 * 8.06428e-05 * 3, 1e-9);
  const base::RotorParams params = load_vehicle("x500").rotors[0].params;
  EXPECT_NEAR(params.torque_coefficient, 0.016 * 8.54858e-06, 1e-12);
  EXPECT_EQ(params.rolling_moment_coefficient, 1e-6);
  EXPECT_EQ(params.time_constant_up_s, 0.0125);
  EXPECT_EQ(params.time_constant_down_s, 0.025);
  EXPECT_EQ(params.omega_max_rad_s, 1000);
}

class ShippedFrame : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(ShippedFrame, IsNumberedAndSpinsAsTheAutopilots) {
  const auto [name, frame_name] = GetParam();
  const base::Vehicle vehicle = load_vehicle(name);
  const auto file = std::filesystem::path(cas::test::source_dir()) / "config/frames.yaml";
  std::vector<std::string> fitting;
  for (const base::Frame& frame : base::load_frames(file)) {
    if (frame.fits(vehicle)) fitting.push_back(frame.name);
  }
  EXPECT_EQ(fitting, std::vector<std::string>{frame_name});
  const auto hover = vehicle.hover_output(9.80665);
  ASSERT_TRUE(hover);
  EXPECT_GT(*hover, 0.4);
  EXPECT_LT(*hover, 0.75);
  // At the hover output the thrust is the weight.
  base::RotorVector omega_sq(vehicle.rotor_count());
  for (int i = 0; i < vehicle.rotor_count(); ++i) {
    const base::RotorParams& params = vehicle.rotors[static_cast<std::size_t>(i)].params;
    const double omega =
        params.omega_idle_rad_s + *hover * (params.omega_max_rad_s - params.omega_idle_rad_s);
    omega_sq[i] = omega * omega;
  }
  EXPECT_NEAR((vehicle.effectiveness() * omega_sq)[2], vehicle.mass_kg * 9.80665, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(
    All, ShippedFrame,
    testing::Values(std::pair("iris_px4", "quad x"), std::pair("quad_x", "quad x"),
                    std::pair("x500", "quad x"), std::pair("hexa_x", "hexa x"),
                    std::pair("hexa_tilt", "hexa x"), std::pair("octo_x", "octo x"),
                    std::pair("y6", "coaxial y6"), std::pair("tri", "tricopter"),
                    std::pair("quad_plus", "quad +"), std::pair("quad_h", "quad h"),
                    std::pair("x8", "coaxial x8")),
    [](const auto& test) { return std::string(test.param.first); });

}  // namespace
}  // namespace cas::sim
