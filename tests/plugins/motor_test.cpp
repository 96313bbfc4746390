// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "plugins/motor/battery_model.hpp"
#include "plugins/motor/body_drag.hpp"
#include "plugins/motor/motor_mixer.hpp"
#include "plugins/motor/rotor_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using test::load_vehicle;
using testing::HasSubstr;

constexpr double kExact = 1e-9;

// Coefficients in round numbers; every secondary effect off unless a test turns it on.
base::Vehicle simple_vehicle() {
  base::Vehicle vehicle = load_vehicle("iris_px4");
  for (base::Rotor& rotor : vehicle.rotors) {
    rotor.params = {.thrust_coefficient = 1e-5,
                    .torque_coefficient = 2e-7,
                    .omega_max_rad_s = 1000,
                    .omega_idle_rad_s = 100,
                    .time_constant_up_s = 0.02,
                    .time_constant_down_s = 0.04,
                    .radius_m = 0.1};
  }
  return vehicle;
}

/// One coefficient of every rotor.
void set_all(base::Vehicle& vehicle, double base::RotorParams::*member, double value) {
  for (base::Rotor& rotor : vehicle.rotors) rotor.params.*member = value;
}

struct Result {
  Wrench wrench;
  std::array<double, 4> omega_dot{};
};

Result evaluate(const RotorModel& rotors, const Vector4d& omega, const BodyState& body = {},
                const Environment& environment = {}) {
  Result result;
  rotors.evaluate(body, environment, {omega.data(), 4}, result.omega_dot, result.wrench);
  return result;
}

MotorCommand armed(MotorCommand::Kind kind, const Vector4d& values) {
  MotorCommand command;
  command.armed = true;
  command.kind = kind;
  command.values = values;
  return command;
}

MotorCommand control_inputs(double u1, double u2, double u3, double u4) {
  return armed(MotorCommand::Kind::kControlInputs, {u1, u2, u3, u4});
}

MotorCommand motor_outputs(const Vector4d& values) {
  return armed(MotorCommand::Kind::kMotorOutputs, values);
}

TEST(MotorMixer, InvertsEquation3) {
  const base::Vehicle vehicle = load_vehicle("iris_paper");
  const MotorMixer mixer(vehicle);
  const Vector4d inputs(15.0, 0.2, -0.3, 0.05);
  const Vector4d omega = mixer.targets(control_inputs(15.0, 0.2, -0.3, 0.05));
  EXPECT_TRUE((vehicle.mixing_matrix() * omega.cwiseAbs2()).isApprox(inputs, kExact));
}

TEST(MotorMixer, HoldsSpeedsBetweenIdleAndMaximum) {
  const base::Vehicle vehicle = load_vehicle("iris_paper");
  const MotorMixer mixer(vehicle);
  const Vector4d low = mixer.targets(control_inputs(0, 0, 0, 0));
  EXPECT_TRUE(low.isApprox(Vector4d::Constant(vehicle.rotors[0].params.omega_idle_rad_s)));
  const Vector4d high = mixer.targets(control_inputs(1000, 0, 0, 0));
  EXPECT_TRUE(high.isApprox(Vector4d::Constant(vehicle.rotors[0].params.omega_max_rad_s)));
}

TEST(MotorMixer, MotorOutputsFollowTheLawOfPx4sIris) {
  const MotorMixer mixer(load_vehicle("iris_px4"));
  MotorCommand command = motor_outputs({0.0, 0.705, 1.0, 1.7});
  EXPECT_TRUE(mixer.targets(command).isApprox(Vector4d(100, 805, 1100, 1100), kExact));
  command.values = Eigen::Vector4d(-0.1, -0.1, -1.2, 0.0);
  EXPECT_TRUE(mixer.targets(command).isApprox(Vector4d::Constant(100), kExact));
}

TEST(MotorMixer, StopsRotorsWhenDisarmed) {
  const MotorMixer mixer(load_vehicle("iris_px4"));
  MotorCommand command = control_inputs(15, 0, 0, 0);
  command.armed = false;
  EXPECT_TRUE(mixer.targets(command).isZero(0.0));
}

TEST(MotorMixer, TakesWhatIsNoNumberForZero) {
  const MotorMixer mixer(load_vehicle("iris_px4"));
  const Vector4d no_numbers = Vector4d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(mixer.targets(motor_outputs(no_numbers)).isApprox(Vector4d::Constant(100)));
}

TEST(RotorModel, GivesTheControlInputsOfEquation3) {
  const base::Vehicle vehicle = load_vehicle("iris_paper");
  RotorModel rotors(vehicle);
  const Vector4d omega(700, 800, 750, 820);
  rotors.set_targets(omega);
  BodyState body;
  const Result result = evaluate(rotors, omega, body);
  const Vector4d inputs = vehicle.mixing_matrix() * omega.cwiseAbs2();
  EXPECT_NEAR(result.wrench.force_B.z(), inputs[0], kExact);  // up in B = -Dz
  EXPECT_NEAR(result.wrench.torque_B.x(), inputs[1], kExact);
  EXPECT_NEAR(result.wrench.torque_B.y(), -inputs[2], kExact);  // Dy = -By
  EXPECT_NEAR(result.wrench.torque_B.z(), -inputs[3], kExact);
}

TEST(RotorModel, CounterClockwiseRotorYawsTheBodyClockwise) {
  const RotorModel rotors(simple_vehicle());
  const Result result = evaluate(rotors, {500, 0, 0, 0});  // rotor 1 is counter-clockwise
  EXPECT_NEAR(result.wrench.torque_B.z(), -2e-7 * 500 * 500, kExact);
}

TEST(RotorModel, LagsWithItsOwnTimeConstantUpAndDown) {
  RotorModel rotors(simple_vehicle());
  rotors.set_targets(Eigen::Vector4d(600, 400, 500, 500));
  const Result result = evaluate(rotors, Vector4d::Constant(500));
  EXPECT_NEAR(result.omega_dot[0], 100 / 0.02, kExact);
  EXPECT_NEAR(result.omega_dot[1], -100 / 0.04, kExact);
  EXPECT_NEAR(result.omega_dot[2], 0, kExact);
}

TEST(RotorModel, WithoutLagSpeedsAreTheirTargets) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::time_constant_up_s, 0);
  set_all(vehicle, &base::RotorParams::time_constant_down_s, 0);
  RotorModel rotors(vehicle);
  rotors.set_targets(Eigen::Vector4d(600, 400, 1500, 0));
  std::array<double, 4> omega{500, 500, 500, 500};
  rotors.limit(omega);
  EXPECT_EQ(omega, (std::array<double, 4>{600, 400, 1000, 0}));
}

TEST(MotorMixer, AReversibleRotorTakesOutputsBelowZero) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::omega_idle_rad_s, 0);
  vehicle.rotors[1].params.reversible = true;
  MotorCommand command = motor_outputs({0.5, -0.5, 0.25, 0});
  const MotorMixer mixer(vehicle);
  EXPECT_TRUE(mixer.targets(command).isApprox(Vector4d(500, -500, 250, 0)));
  EXPECT_FALSE(mixer.refused_reverse(command));
  command.values = Vector4d(-0.5, -2, 0, 0);
  EXPECT_EQ(mixer.targets(command)[0], 0) << "not reversible";
  EXPECT_EQ(mixer.targets(command)[1], -1000);
  EXPECT_EQ(mixer.refused_reverse(command), 0);
}

TEST(RotorModel, AReversedRotorPullsTheOtherWay) {
  base::Vehicle vehicle = simple_vehicle();
  for (base::Rotor& rotor : vehicle.rotors) rotor.params.reversible = true;
  RotorModel rotors(vehicle);
  const Wrench up = evaluate(rotors, {500, 0, 0, 0}).wrench;
  const Wrench down = evaluate(rotors, {-500, 0, 0, 0}).wrench;
  EXPECT_LT((up.force_B + down.force_B).norm(), kExact);
  EXPECT_LT((up.torque_B + down.torque_B).norm(), kExact);
  EXPECT_GT(up.force_B.z(), 0);
  // It speeds up with the lag upwards, whichever way it turns.
  rotors.set_targets(Vector4d(-600, -400, 0, 0));
  const Result result = evaluate(rotors, {-500, -500, 0, 0});
  EXPECT_NEAR(result.omega_dot[0], -100 / 0.02, kExact);
  EXPECT_NEAR(result.omega_dot[1], 100 / 0.04, kExact);
}

TEST(RotorModel, SpinUpTurnsTheBodyBack) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::torque_coefficient, 0);
  set_all(vehicle, &base::RotorParams::inertia_kg_m2, 1e-5);
  RotorModel rotors(vehicle);
  rotors.set_targets(Eigen::Vector4d(600, 500, 500, 500));
  const Result result = evaluate(rotors, Vector4d::Constant(500));
  EXPECT_NEAR(result.wrench.torque_B.z(), -1e-5 * 100 / 0.02, kExact);
}

TEST(RotorModel, SpinningRotorsResistTurningLikeAGyroscope) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::thrust_coefficient, 0);
  set_all(vehicle, &base::RotorParams::torque_coefficient, 0);
  set_all(vehicle, &base::RotorParams::inertia_kg_m2, 1e-5);
  RotorModel rotors(vehicle);
  const Vector4d omega(500, 0, 0, 200);  // H = (500 - 200) J along +Bz
  rotors.set_targets(omega);
  BodyState body{.w_WB_B = {2, 3, 1}};
  const Vector3d momentum(0, 0, 300 * 1e-5);
  EXPECT_TRUE(
      evaluate(rotors, omega, body).wrench.torque_B.isApprox(-body.w_WB_B.cross(momentum), kExact));
}

TEST(RotorModel, DragsAgainstTheAirInTheRotorPlane) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::thrust_coefficient, 0);
  set_all(vehicle, &base::RotorParams::drag_coefficient, 1.75e-4);
  const RotorModel rotors(vehicle);
  BodyState body{.v_WB = {3, 0, 2}};
  Environment air;
  air.wind_W = {1, 0, 0};
  const Result result = evaluate(rotors, Vector4d::Constant(805), body, air);
  EXPECT_TRUE(result.wrench.force_B.isApprox(Vector3d(-4 * 1.75e-4 * 805 * 2, 0, 0), kExact));
}

TEST(RotorModel, HoverDragMatchesTheFigureOfTheIris) {
  // 4 * 1.75e-4 * 805 = 0.564 N per m/s.
  base::Vehicle vehicle = load_vehicle("iris_px4");
  const RotorModel rotors(vehicle);
  BodyState body{.v_WB = {1, 0, 0}};
  EXPECT_NEAR(evaluate(rotors, Vector4d::Constant(805), body).wrench.force_B.x(), -0.5635, 1e-4);
}

TEST(RotorModel, AdvancingBladesRollOneRotorAndCancelOverFour) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::thrust_coefficient, 0);
  set_all(vehicle, &base::RotorParams::torque_coefficient, 0);
  set_all(vehicle, &base::RotorParams::rolling_moment_coefficient, 1e-6);
  const RotorModel rotors(vehicle);
  BodyState body{.v_WB = {10, 0, 0}};
  // A counter-clockwise rotor advances on the right: more lift there rolls the body to the left.
  EXPECT_NEAR(evaluate(rotors, {500, 0, 0, 0}, body).wrench.torque_B.x(), -1e-6 * 500 * 10, kExact);
  EXPECT_NEAR(evaluate(rotors, Vector4d::Constant(500), body).wrench.torque_B.x(), 0, kExact);
}

TEST(RotorModel, ThrustFadesWithAxialSpeed) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::zero_thrust_speed_m_s, 25);
  const RotorModel rotors(vehicle);
  const double still = evaluate(rotors, Vector4d::Constant(500)).wrench.force_B.z();
  BodyState body{.v_WB = {0, 0, 5}};
  EXPECT_NEAR(evaluate(rotors, Vector4d::Constant(500), body).wrench.force_B.z(), 0.8 * still,
              kExact);
  body.v_WB = {0, 0, -30};
  EXPECT_NEAR(evaluate(rotors, Vector4d::Constant(500), body).wrench.force_B.z(), 0, kExact);
}

TEST(RotorModel, ThinAirTakesThrustAndTorque) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::reference_density_kg_m3, 1.225);
  const RotorModel rotors(vehicle);
  Environment air;
  air.air_density_kg_m3 = 1.225 / 2;
  const Result result = evaluate(rotors, {500, 0, 0, 0}, {}, air);
  EXPECT_NEAR(result.wrench.force_B.z(), 0.5 * 1e-5 * 500 * 500, kExact);
  EXPECT_NEAR(result.wrench.torque_B.z(), -0.5 * 2e-7 * 500 * 500, kExact);
}

TEST(RotorModel, GroundEffectIsCheesemanAndBennetts) {
  EXPECT_NEAR(RotorModel::ground_effect(0.1, 0.1), 1.0667, 1e-4);     // z = R
  EXPECT_NEAR(RotorModel::ground_effect(0.2, 0.1), 1.0159, 1e-4);     // z = 2 R
  EXPECT_NEAR(RotorModel::ground_effect(0.0, 0.1), 4.0 / 3.0, 1e-9);  // held at z = R / 2
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::ground_effect, 1);
  for (auto& rotor : vehicle.rotors) rotor.position_B_m.z() = 0.02;
  const RotorModel rotors(vehicle);
  Environment ground;
  ground.height_above_ground_m = 0.08;  // hubs at z = R
  EXPECT_NEAR(evaluate(rotors, Vector4d::Constant(500), {}, ground).wrench.force_B.z(),
              4 * 1e-5 * 500 * 500 * 16.0 / 15.0, kExact);
}

TEST(BodyDrag, IsProportionalToTheSpeedThroughTheAir) {
  const BodyDrag drag(0.3);
  BodyState body{.v_WB = {4, 1, -2}};
  body.q_WB = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized());
  Environment environment;
  environment.wind_W = {1, 1, 0};
  Wrench wrench;
  drag.evaluate(body, environment, {}, {}, wrench);
  EXPECT_LT((body.q_WB * wrench.force_B - Vector3d(-0.9, 0, 0.6)).norm(), kExact);
  EXPECT_EQ(wrench.torque_B, Vector3d::Zero());
}

TEST(BodyDrag, GrowsWithTheSquareByAxisAndTurnsTheBodyAboutItsCentre) {
  const Vector3d centre_B(-0.1, 0, 0.05);
  const BodyDrag drag(0,
                      base::BodyDragParams{.area_m2 = {0.01, 0.02, 0.04}, .centre_B_m = centre_B});
  BodyState body;
  body.q_WB = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized());
  body.v_WB = body.q_WB * Vector3d(5, 0, 1);
  body.w_WB_B = {0, 10, 0};
  Environment environment;
  environment.air_density_kg_m3 = 1.2;
  environment.wind_W = body.q_WB * Vector3d(1, 2, 0);
  // The wind dies away towards the tail: at the centre of pressure less by 3 m/s forward.
  Eigen::Matrix3d gradient_B = Eigen::Matrix3d::Zero();
  gradient_B(0, 0) = 30;
  environment.wind_gradient_W = body.q_WB * gradient_B * body.q_WB.conjugate();
  Wrench wrench;
  drag.evaluate(body, environment, {}, {}, wrench);
  // Of the centre of gravity (4, -2, 1), of the turn (0.5, 0, 1), of the gradient (3, 0, 0).
  const Vector3d v_B(7.5, -2, 2);
  const Vector3d force_B = -0.6 * v_B.norm() * Vector3d(0.01 * 7.5, 0.02 * -2, 0.04 * 2);
  EXPECT_TRUE(wrench.force_B.isApprox(force_B, kExact)) << wrench.force_B.transpose();
  EXPECT_TRUE(wrench.torque_B.isApprox(centre_B.cross(force_B), kExact));
}

TEST(RotorModel, MeetsTheWindAtTheHubOfEachRotor) {
  base::Vehicle vehicle = simple_vehicle();
  set_all(vehicle, &base::RotorParams::thrust_coefficient, 0);
  set_all(vehicle, &base::RotorParams::torque_coefficient, 0);
  set_all(vehicle, &base::RotorParams::drag_coefficient, 1e-4);
  const RotorModel rotors(vehicle);
  BodyState body;
  body.q_WB = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());  // forward is north, +y of W
  Environment air;
  air.wind_W = {1, 0, 0};
  Eigen::Matrix3d gradient_W = Eigen::Matrix3d::Zero();
  gradient_W(0, 1) = 4;  // east wind's speed rises northwards
  air.wind_gradient_W = gradient_W;
  // At a hub x forward of the centre the air moves east, to the right, with 1 + 4 x.
  Vector3d force_B = Vector3d::Zero();
  Vector3d torque_B = Vector3d::Zero();
  for (const base::Rotor& rotor : vehicle.rotors) {
    const Vector3d drag_B(0, -1e-4 * 500 * (1 + 4 * rotor.position_B_m.x()), 0);
    force_B += drag_B;
    torque_B += rotor.position_B_m.cross(drag_B);
  }
  const Wrench wrench = evaluate(rotors, Vector4d::Constant(500), body, air).wrench;
  EXPECT_TRUE(wrench.force_B.isApprox(force_B, kExact));
  EXPECT_TRUE(wrench.torque_B.isApprox(torque_B, kExact)) << wrench.torque_B.transpose();
}

TEST(MotorPlugin, DrivesItsForceModelFromTheBus) {
  test::PluginHarness harness;
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("motor", "{}");
  const test::Heard<RotorSpeeds> speeds(harness, "rotor_speeds");
  ASSERT_EQ(harness.context.force_models.size(), 1U);
  command.publish(motor_outputs(Vector4d::Constant(0.7)));

  std::array<double, 4> omega{};
  std::array<double, 4> omega_dot{};
  Wrench wrench;
  harness.context.force_models[0]->evaluate({}, {}, omega, omega_dot, wrench);
  EXPECT_NEAR(omega_dot[0], 800 / 0.0125, 1e-6);

  harness.world.model_states[harness.context.force_models[0]] = {1, 2, 3, 4};
  harness.step();
  ASSERT_EQ(speeds.all.size(), 1U);
  EXPECT_TRUE(speeds.newest.omega_rad_s.isApprox(Vector4d(1, 2, 3, 4)));
  EXPECT_EQ(speeds.newest.time.time_since_epoch(), std::chrono::milliseconds(1));
}

constexpr base::BatteryParams kBattery{
    .full_v = 16, .empty_v = 12, .capacity_ah = 1, .resistance_ohm = 0.1, .efficiency = 0.5};

TEST(MotorPlugin, RefusesALagFarShorterThanTheStep) {
  const auto refusal_of = [](double lag_s) {
    test::PluginHarness harness(std::chrono::milliseconds(1), ".", "iris_px4",
                                [lag_s](base::Vehicle& vehicle) {
                                  for (base::Rotor& rotor : vehicle.rotors)
                                    rotor.params.time_constant_up_s = lag_s;
                                });
    return test::refusal([&] { harness.add("motor", "{}"); });
  };
  EXPECT_EQ(refusal_of(1e-5),
            "a rotor's time constant of 1e-05 s is shorter than half the step of 0.001 s: give 0, "
            "which has no lag, or a smaller step_us");
  EXPECT_EQ(refusal_of(0.001), "");
  EXPECT_EQ(refusal_of(0), "");
}

TEST(Battery, SagsUnderLoad) {
  BatteryModel battery(kBattery);
  EXPECT_DOUBLE_EQ(battery.speed_share(), 1.0);
  battery.advance(100, 0.0);  // 200 W from the battery
  // V (V0 - V) / R = P: V = (16 + sqrt(256 - 4 * 0.1 * 200)) / 2.
  EXPECT_NEAR(battery.voltage_v(), (16 + std::sqrt(176.0)) / 2, kExact);
  EXPECT_NEAR(battery.voltage_v() * battery.current_a(), 200, 1e-9);
}

TEST(Battery, EmptiesByItsCurrent) {
  BatteryModel battery(kBattery);
  double used_ah = 0;
  for (int i = 0; i < 60; ++i) {
    battery.advance(100, 1.0);
    used_ah += battery.current_a() / 3600;
  }
  EXPECT_NEAR(battery.charge(), 1 - used_ah, kExact);
  for (int i = 0; i < 1000; ++i) battery.advance(100, 1.0);
  EXPECT_DOUBLE_EQ(battery.charge(), 0);
  EXPECT_DOUBLE_EQ(battery.voltage_v(), 0) << "empty, it gives nothing";
  EXPECT_DOUBLE_EQ(battery.current_a(), 0);
}

TEST(MotorPlugin, AnEmptyBatteryLetsTheRotorsDown) {
  test::PluginHarness harness(std::chrono::milliseconds(1), ".", "iris_px4", [](base::Vehicle& v) {
    v.battery = {.full_v = 16,
                 .empty_v = 12,
                 .capacity_ah = 1e-4,
                 .resistance_ohm = 0.001,
                 .efficiency = 0.5};
  });
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("motor", "{}");
  command.publish(motor_outputs(Vector4d::Constant(0.7)));  // 800 rad/s
  ForceModel& rotors = *harness.context.force_models[0];
  auto& omega = harness.world.model_states.at(&rotors);
  std::fill(omega.begin(), omega.end(), 800.0);
  std::array<double, 4> omega_dot{};
  Wrench wrench;
  harness.step();
  rotors.evaluate({}, {}, omega, omega_dot, wrench);
  EXPECT_GT(omega_dot[0], -800 * 0.25 / 0.025) << "it sags, and still drives";
  for (int i = 0; i < 100; ++i) harness.step();  // 0.36 C at some 90 A: 4 ms
  rotors.evaluate({}, {}, omega, omega_dot, wrench);
  EXPECT_NEAR(omega_dot[0], -800 / 0.025, 1e-6) << "no speed is asked for any more";
}

TEST(MotorPlugin, ASpeedControllersDeadTimeHoldsACommandBack) {
  test::PluginHarness harness(std::chrono::milliseconds(1), ".", "iris_px4", [](base::Vehicle& v) {
    for (auto& rotor : v.rotors) rotor.params.esc_dead_time_s = 0.003;
    v.rotors[3].params.esc_dead_time_s = 0;
  });
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("motor", "{}");
  ForceModel& rotors = *harness.context.force_models[0];
  const std::array<double, 4> standing{};
  std::array<double, 4> omega_dot{};
  std::vector<double> first, last;  // speeds that rotors 1 and 4 are outputs to
  for (int step = 0; step < 8; ++step) {
    command.publish(motor_outputs(Vector4d::Constant(0.1 * step)));
    harness.step();
    Wrench wrench;
    rotors.evaluate({}, {}, standing, omega_dot, wrench);
    first.push_back(std::round(omega_dot[0] * 0.0125));
    last.push_back(std::round(omega_dot[3] * 0.0125));
  }
  // Commands at 0, 1, 2 ... ms; targets in the step that begins a millisecond later.
  EXPECT_EQ(first, (std::vector<double>{0, 0, 100, 200, 300, 400, 500, 600}));
  EXPECT_EQ(last, (std::vector<double>{100, 200, 300, 400, 500, 600, 700, 800}));
}

TEST(MotorPlugin, TellsItsBatteryTwiceASecond) {
  test::PluginHarness harness(std::chrono::milliseconds(1), ".", "iris_px4",
                              [](base::Vehicle& v) { v.battery = kBattery; });
  const auto health = harness.bus.advertise<PropulsionHealth>("iris0/propulsion_health");
  harness.add("motor", "{}");
  const test::Heard<BatterySample> heard(harness, "battery");
  const auto& samples = heard.all;
  auto& omega = harness.world.model_states.at(harness.context.force_models[0]);
  std::fill(omega.begin(), omega.end(), 500.0);
  harness.run(std::chrono::seconds(2));
  ASSERT_EQ(samples.size(), 4U);
  const BatterySample& last = samples.back();
  EXPECT_EQ(last.time.time_since_epoch(), std::chrono::seconds(2));
  EXPECT_LT(last.voltage_v, kBattery.full_v);
  EXPECT_GT(last.current_a, 0);
  EXPECT_NEAR(last.used_ah, (1 - last.charge) * kBattery.capacity_ah, kExact);
  EXPECT_NEAR(last.used_ah, last.current_a * 2 / 3600, 0.01 * last.used_ah) << "an even load";

  health.publish(PropulsionHealth{.voltage_share = 0.9});
  harness.run(std::chrono::milliseconds(500));
  ASSERT_EQ(samples.size(), 5U);
  EXPECT_NEAR(samples[4].voltage_v, 0.9 * samples[3].voltage_v, 0.05) << "a fault is measured, too";
}

TEST(MotorPlugin, WithoutABatteryTellsOfNone) {
  test::PluginHarness harness;
  harness.add("motor", "{}");
  int samples = 0;
  const auto listening = harness.bus.subscribe<BatterySample>(
      "iris0/battery", [&](const BatterySample&) { ++samples; }, Need::kOptional);
  harness.run(std::chrono::seconds(1));
  EXPECT_EQ(samples, 0);
}

TEST(Battery, GivesHalfItsVoltageBeyondWhatItCanGive) {
  BatteryModel battery(kBattery);
  battery.advance(5e8, 0.0);
  EXPECT_DOUBLE_EQ(battery.voltage_v(), 8);
}

TEST(MotorPlugin, PassesBrokenRotorsOn) {
  test::PluginHarness harness;
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  const auto health = harness.bus.advertise<PropulsionHealth>("iris0/propulsion_health");
  harness.add("motor", "{}");
  command.publish(motor_outputs(Vector4d::Constant(0.7)));  // 800 rad/s
  PropulsionHealth broken{.speed_share = Eigen::Vector4d(1, 0, 1, 1),
                          .thrust_share = Eigen::Vector4d(1, 1, 0.5, 1),
                          .voltage_share = 0.5};
  health.publish(broken);
  std::array<double, 4> omega{400, 400, 400, 400};
  std::array<double, 4> omega_dot{};
  Wrench wrench;
  harness.context.force_models[0]->evaluate({}, {}, omega, omega_dot, wrench);
  EXPECT_NEAR(omega_dot[0], 0, 1e-9);             // 800 * 0.5
  EXPECT_NEAR(omega_dot[1], -400 / 0.025, 1e-6);  // stopped
  EXPECT_NEAR(wrench.force_B.z(), 3.5 * 5.84e-6 * 400 * 400, 1e-9);
}

TEST(MotorPlugin, StuckRotorsKeepTheirSpeedAndSwappedOnesGetEachOthers) {
  test::PluginHarness harness;
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  const auto health = harness.bus.advertise<PropulsionHealth>("iris0/propulsion_health");
  harness.add("motor", "{}");
  MotorCommand outputs = motor_outputs(Vector4d::Constant(0.7));  // 800 rad/s
  command.publish(outputs);
  PropulsionHealth broken;
  broken.stuck[0] = true;
  std::swap(broken.wired_as[1], broken.wired_as[3]);
  broken.thrust_share[2] = -0.5;
  health.publish(broken);
  outputs.values = Vector4d(0, 0, 0, 0.7);
  command.publish(outputs);
  const std::array<double, 4> omega{400, 400, 400, 400};
  std::array<double, 4> omega_dot{};
  Wrench wrench;
  harness.context.force_models[0]->evaluate({}, {}, omega, omega_dot, wrench);
  EXPECT_NEAR(omega_dot[0], 400 / 0.0125, 1e-6) << "still to 800";
  EXPECT_NEAR(omega_dot[1], 400 / 0.0125, 1e-6) << "what is meant for rotor 4";
  EXPECT_LT(omega_dot[3], 0) << "what is meant for rotor 2";
  EXPECT_NEAR(wrench.force_B.z(), 2.5 * 5.84e-6 * 400 * 400, 1e-9) << "rotor 3 pulls down";

  outputs.armed = false;
  command.publish(outputs);
  harness.context.force_models[0]->evaluate({}, {}, omega, omega_dot, wrench);
  EXPECT_NEAR(omega_dot[0], 400 / 0.0125, 1e-6) << "disarmed, it turns on";
  EXPECT_LT(omega_dot[1], 0);
}

TEST(MotorPlugin, ARotorThatTouchesSomethingStopsForGood) {
  test::PluginHarness harness;
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  const test::Heard<RotorSpeeds> speeds(harness, "rotor_speeds");
  const Plugin& motor = harness.add("motor", "{}");
  MotorCommand outputs = motor_outputs(Vector4d::Constant(0.7));  // 800 rad/s
  command.publish(outputs);
  ForceModel& rotors = *harness.context.force_models[0];
  auto& states = harness.world.model_states.at(&rotors);
  std::fill(states.begin(), states.end(), 800.0);

  harness.world.touched_disc_B = harness.context.vehicle().rotors[2].position_B_m;
  states[2] = 0.5;  // as good as standing
  harness.step();
  EXPECT_EQ(motor.stats_json(), "") << "what stands hits nothing";
  states[2] = 800;
  harness.step();
  harness.world.touched_disc_B.reset();
  std::array<double, 4> omega_dot{};
  Wrench wrench;
  rotors.evaluate({}, {}, states, omega_dot, wrench);
  EXPECT_NEAR(wrench.force_B.z(), 3 * 5.84e-6 * 800 * 800, 1e-6) << "no thrust from rotor 3";
  rotors.limit(states);
  harness.step();
  EXPECT_EQ(speeds.newest.omega_rad_s, Vector4d(800, 800, 0, 800));
  command.publish(outputs);
  rotors.evaluate({}, {}, states, omega_dot, wrench);
  EXPECT_EQ(omega_dot[2], 0.0) << "asked to turn again, it does not";
  EXPECT_THAT(motor.stats_json(), HasSubstr("\"rotor_strikes\":[{\"rotor\":3,\"time_s\":0.002"));
  harness.reset();
  EXPECT_EQ(motor.stats_json(), "");
}

TEST(MotorPlugin, SaysThatARotorDoesNotTurnTheOtherWay) {
  test::PluginHarness harness;
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  const Plugin& motor = harness.add("motor", "{}");
  command.publish(motor_outputs(Vector4d(0.5, 0.5, 0, -0.3)));
  EXPECT_THAT(motor.stats_json(),
              HasSubstr("{\"warnings\":[\"iris0: rotor 4 was asked to turn the other"));
  harness.reset();
  EXPECT_EQ(motor.stats_json(), "");
}

}  // namespace
}  // namespace cas::sim
