// SPDX-License-Identifier: BSD-3-Clause
// Propellers by advance ratio and motors as circuits, against closed forms and the Aerosonde of R.
// W. Beard, T. W. McLain, "Small Unmanned Aircraft", Princeton, 2012, Ch. 4 and its supplement.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "libsim/core/body/rigid_body.hpp"
#include "plugins/motor/battery_model.hpp"
#include "plugins/motor/motor_circuit.hpp"
#include "plugins/motor/rotor_model.hpp"
#include "tests/plugins/plugin_harness.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;

constexpr double kLastDigits = 1e-12;
constexpr double kBookDensity = 1.2682;

/// The book's propeller of 20 in and its motor of 145 rpm/V, pulling forward, on 44.4 V.
base::Vehicle aerosonde() { return test::load_vehicle("aerosonde"); }

/// Runs the rotors alone at a steady speed through the air, in steps of 1 ms.
struct Bench {
  explicit Bench(const base::Vehicle& vehicle) : model(vehicle) {
    forces.add(model);
    forces.reset_states();
    air.air_density_kg_m3 = kBookDensity;
  }
  Wrench run(double seconds, double dt = 1e-3) {
    Wrench wrench;
    for (int i = 0; i < std::lround(seconds / dt); ++i) {
      wrench = integrate_forces(body, forces, air, {}, dt);
    }
    return wrench;
  }
  double omega(std::size_t rotor = 0) { return forces.states()[rotor]; }

  RotorModel model;
  ForceSet forces;
  BodyState body;
  Environment air;
};

/// Trims of the book's set, from its algebraic motor: a w^2 + b w + c0 = 0.
TEST(Aerosonde, SettlesAtTheSpeedAndThrustOfTheBook) {
  struct TrimCase {
    const char* name;
    double speed_m_s, throttle, thrust_n, omega_rad_s;
  };
  const TrimCase rows[] = {{"At20", 20, 0.6294, 7.618, 419.0},
                           {"At25", 25, 0.7735, 10.330, 514.4},
                           {"At30", 30, 0.9246, 14.195, 613.8}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    constexpr double kFourDigits = 2e-4;  // the throttle has four
    const TrimCase& trim = row;
    const base::Vehicle vehicle = aerosonde();
    Bench bench(vehicle);
    bench.body.v_WB = {trim.speed_m_s, 0, 0};
    const double asked = vehicle.rotors[0].speed_at(trim.throttle);
    bench.model.set_targets(base::RotorVector::Constant(1, asked));
    const Wrench wrench = bench.run(3);
    EXPECT_NEAR(bench.omega() / trim.omega_rad_s, 1, kFourDigits);
    EXPECT_NEAR(wrench.force_B.x() / trim.thrust_n, 1, 2 * kFourDigits);

    // The same by the book's quadratic, to the last digit.
    const double d = 0.508, k = 60 / (2 * M_PI * 145), r = 0.042, v = trim.speed_m_s;
    const double a = kBookDensity * std::pow(d, 5) * 0.00523 / (4 * M_PI * M_PI);
    const double b = kBookDensity * std::pow(d, 4) * 0.00497 * v / (2 * M_PI) + k * k / r;
    const double c0 =
        kBookDensity * std::pow(d, 3) * -0.01664 * v * v - k * 44.4 * trim.throttle / r + k * 1.5;
    const double omega = (-b + std::sqrt(b * b - 4 * a * c0)) / (2 * a);
    EXPECT_NEAR(bench.omega() / omega, 1, 1e-9);
  }
}

/// J dw/dt = -(K i_0 + k_q w^2) without current: w = sqrt(a / b) tan(c - sqrt(a b) t) with a = K
/// i_0 / J and b = k_q / J. With current again it comes back.
TEST(Desync, ARotorWithoutCurrentCoastsAndComesBack) {
  const base::Vehicle vehicle = aerosonde();
  const base::ElectricMotor& motor = *vehicle.rotors[0].electric;
  Bench bench(vehicle);
  bench.model.set_targets(base::RotorVector::Constant(1, vehicle.rotors[0].speed_at(0.7)));
  bench.run(3);
  const double before = bench.omega();
  bench.model.cut_currents({true});
  EXPECT_EQ(bench.model.supply(bench.forces.states()).motor_a[0], 0);
  bench.run(0.5);
  const double j = vehicle.rotors[0].params.inertia_kg_m2;
  const double a = motor.torque_constant_nm_a * motor.no_load_current_a / j;
  const double b = vehicle.rotors[0].propeller->torque_nm(kBookDensity, 1, 0) / j;
  const double c = std::atan(before * std::sqrt(b / a));
  EXPECT_NEAR(bench.omega() / (std::sqrt(a / b) * std::tan(c - std::sqrt(a * b) * 0.5)), 1, 1e-6);
  EXPECT_LT(bench.omega(), 0.9 * before);
  bench.model.cut_currents({false});
  bench.run(3);
  EXPECT_NEAR(bench.omega() / before, 1, 1e-6);
}

// The propeller.

/// APC 10x4.7 SF of the UIUC Propeller Database, volume 1 (J. B. Brandt, R. W. Deters, G. K.
/// Ananda, O. D. Dantsker, M. S. Selig): apcsf_10x4.7_kt0836_4014, every second row. C_T and C_P
/// over J.
const std::vector<double> kRatios{0.142, 0.216, 0.289, 0.361, 0.438, 0.510, 0.577, 0.647, 0.719};
const std::vector<double> kThrusts{0.0994, 0.0885, 0.0770,  0.0652, 0.0502,
                                   0.0343, 0.0178, -0.0011, -0.0218};
const std::vector<double> kPowers{0.0451, 0.0436, 0.0414, 0.0392, 0.0352,
                                  0.0308, 0.0258, 0.0199, 0.0130};

TEST(PropellerCurve, PassesThroughItsRowsAndMeetsThoseThatWereLeftOut) {
  const auto thrust = base::PropellerCurve::table(kRatios, kThrusts);
  const auto power = base::PropellerCurve::table(kRatios, kPowers);
  for (std::size_t i = 0; i < kRatios.size(); ++i) {
    EXPECT_NEAR(thrust.scaled(1, kRatios[i]), kThrusts[i], kLastDigits);
  }
  const double left_out[][3]{{0.177, 0.0944, 0.0446}, {0.255, 0.0829, 0.0427},
                             {0.325, 0.0719, 0.0407}, {0.399, 0.0582, 0.0375},
                             {0.468, 0.0441, 0.0335}, {0.534, 0.0288, 0.0292},
                             {0.612, 0.0083, 0.0228}, {0.685, -0.0122, 0.0162}};
  constexpr double kTunnel = 1e-3;  // scatter of the measurement
  for (const auto& [j, ct, cp] : left_out) {
    EXPECT_NEAR(thrust.scaled(1, j), ct, kTunnel) << j;
    EXPECT_NEAR(power.scaled(1, j), cp, kTunnel) << j;
  }
  // Static, apcsf_10x4.7_static_kt0835: the tangent reaches back from J = 0.142.
  EXPECT_NEAR(thrust.at_rest(), 0.1157, 0.05 * 0.1157);
  EXPECT_NEAR(power.at_rest(), 0.0465, 0.05 * 0.0465);
  double before = thrust.scaled(1, -3);
  for (double j = -3; j < 3; j += 1e-3) {
    const double now = thrust.scaled(1, j);
    EXPECT_LE(now, before + kLastDigits) << j << ": a wave";
    before = now;
  }
}

TEST(PropellerCurve, HasNoKinkAtAnyAdvanceRatio) {
  for (const auto& curve : {base::PropellerCurve::table(kRatios, kThrusts),
                            base::PropellerCurve::polynomial(0.00523, 0.00497, -0.01664)}) {
    // Along a circle about n = 0, u = 0, from reverse flow through standing blades' neighbours.
    constexpr double kStep = 1e-4;
    double least_slope = 0, most_slope = 0, most_jump = 0, before = NAN;
    for (double angle = 1e-3; angle < M_PI - 1e-3; angle += kStep) {
      const auto at = [&](double a) { return curve.scaled(std::sin(a), -std::cos(a)); };
      const double slope = (at(angle + kStep) - at(angle)) / kStep;
      if (!std::isnan(before)) most_jump = std::max(most_jump, std::abs(slope - before));
      least_slope = std::min(least_slope, slope);
      most_slope = std::max(most_slope, slope);
      before = slope;
    }
    EXPECT_LT(most_jump, 2e-3 * (most_slope - least_slope));
  }
}

TEST(PropellerCurve, IsFiniteWhereThePropellerStandsOrTheAirIsFast) {
  const auto table = base::PropellerCurve::table(kRatios, kThrusts);
  const auto polynomial = base::PropellerCurve::polynomial(0.09357, -0.06044, -0.1079);
  EXPECT_EQ(table.scaled(0, 0), 0);
  EXPECT_EQ(table.scaled(0, 30), 0) << "a tangent's force goes with n";
  EXPECT_EQ(table.scaled(0, -30), 0);
  EXPECT_DOUBLE_EQ(polynomial.scaled(0, 30), -0.1079 * 900) << "a windmill that stands";
  EXPECT_EQ(polynomial.scaled(0, -30), 0);
  for (const double n : {1e-300, 1e-9, 1.0}) {
    for (const double u : {-1e3, -1e-9, 1e-9, 1e3}) {
      EXPECT_TRUE(std::isfinite(table.scaled(n, u))) << n << " " << u;
    }
  }
  // From behind it tends to a constant: half of the fade's way at J = -0.2, all of it far away.
  EXPECT_NEAR(polynomial.scaled(1, -0.2), 0.09357 + 0.06044 * 0.1, kLastDigits);
  EXPECT_NEAR(polynomial.scaled(1, -1e6), 0.09357 + 0.06044 * 0.2, 1e-6);
}

TEST(Rotors, ThrustAndTorqueFollowTheAdvanceRatio) {
  base::Vehicle vehicle = aerosonde();
  vehicle.rotors[0].electric.reset();
  vehicle.rotors[0].params.inertia_kg_m2 = 0;
  vehicle.rotors[0].position_B_m = {0.2, 0.1, 0};
  RotorModel model(vehicle);
  BodyState body{.v_WB = {18, 3, 0}};
  body.w_WB_B = {0, 0, 2};  // the hub, 0.1 m to the left, meets the air more slowly by 0.2 m/s
  Environment air;
  air.air_density_kg_m3 = 1.1;
  air.wind_W = {-4, 0, 0};
  const std::vector<double> x{400};
  std::vector<double> x_dot(1);
  Wrench wrench;
  model.evaluate(body, air, x, x_dot, wrench);
  const double n = 400 / (2 * M_PI);
  const double j = 21.8 / (n * 0.508);
  const double ct = 0.09357 - 0.06044 * j - 0.1079 * j * j;
  const double cq = 0.00523 + 0.00497 * j - 0.01664 * j * j;
  EXPECT_NEAR(wrench.force_B.x(), 1.1 * n * n * std::pow(0.508, 4) * ct, 1e-9);
  EXPECT_NEAR(wrench.torque_B.x(), -1.1 * n * n * std::pow(0.508, 5) * cq, 1e-9);
  EXPECT_NEAR(model.shaft_powers(body, air, x)[0], -400 * wrench.torque_B.x(), 1e-9);
  // In still air of the reference density it is what effectiveness and scales count with.
  air = {};
  air.air_density_kg_m3 = kBookDensity;
  wrench = {};
  model.evaluate({}, air, x, x_dot, wrench);
  EXPECT_NEAR(wrench.force_B.x(), vehicle.effectiveness()(0, 0) * 400 * 400, 1e-9);
}

// The motor.

TEST(ElectricMotor, HasTheClosedFormsOfADirectCurrentMotor) {
  base::ElectricMotor motor{.torque_constant_nm_a = 60 / (2 * M_PI * 920),
                            .resistance_ohm = 0.1,
                            .max_current_a = 1000,
                            .supply_v = 12};
  EXPECT_NEAR(motor.steady_speed_rad_s(1, 0), 920 * 12 * 2 * M_PI / 60, 1e-9) << "KV V";
  EXPECT_NEAR(motor.current_a(12, 0), 120, kLastDigits) << "V / R";
  EXPECT_NEAR(motor.torque_nm(120, 500), 120 * motor.torque_constant_nm_a, kLastDigits);
  motor.no_load_current_a = 0.8;
  const double unloaded = motor.steady_speed_rad_s(1, 0);
  EXPECT_NEAR(motor.current_a(12, unloaded), 0.8, 1e-9);
  // Efficiency (1 - i0 / i)(1 - i R / V), from power at the shaft over power of the battery.
  const double omega = motor.steady_speed_rad_s(0.7, 2e-7);
  const double i = motor.current_a(0.7 * 12, omega);
  const double efficiency = omega * motor.torque_nm(i, omega) / (0.7 * 12 * i);
  EXPECT_NEAR(efficiency, (1 - 0.8 / i) * (1 - i * 0.1 / 8.4), 1e-9);
  EXPECT_NEAR(motor.torque_nm(i, omega), 2e-7 * omega * omega, 1e-12);
  EXPECT_NEAR(motor.steady_duty(omega, 2e-7), 0.7, kLastDigits);
  EXPECT_NEAR(motor.steady_speed_rad_s(-0.7, 2e-7), -omega, 1e-9);
  EXPECT_EQ(motor.steady_speed_rad_s(0.005, 2e-7), 0) << "friction holds it";
  motor.max_current_a = 5;
  EXPECT_NEAR(2e-7 * std::pow(motor.steady_speed_rad_s(1, 2e-7), 2),
              4.2 * motor.torque_constant_nm_a, 1e-12);
  motor.esc_steps = 200;
  EXPECT_EQ(motor.rounded(0.5024), 0.5);
}

/// Four motors with propellers of k_f and k_m only, on a battery.
base::Vehicle quad(double resistance_ohm = 0) {
  base::Vehicle vehicle = test::load_vehicle("quad_x");
  vehicle.battery = base::BatteryParams{
      .full_v = 16.8, .empty_v = 13.2, .capacity_ah = 5, .resistance_ohm = resistance_ohm};
  for (base::Rotor& rotor : vehicle.rotors) {
    rotor.params.zero_thrust_speed_m_s = 0;
    rotor.params.omega_idle_rad_s = 0;
    rotor.params.inertia_kg_m2 = 4e-5;
    rotor.electric = base::ElectricMotor{.torque_constant_nm_a = 60 / (2 * M_PI * 700),
                                         .resistance_ohm = 0.09,
                                         .no_load_current_a = 0.7,
                                         .max_current_a = 30,
                                         .supply_v = 16.8};
    rotor.params.omega_max_rad_s =
        rotor.electric->steady_speed_rad_s(1, rotor.params.torque_coefficient);
  }
  vehicle.settle_lags();
  return vehicle;
}

TEST(MotorCircuit, AStepRisesWithJROverKSquared) {
  base::Vehicle vehicle = quad();
  for (base::Rotor& rotor : vehicle.rotors) {
    rotor.params.torque_coefficient = 1e-15;
    rotor.electric->no_load_current_a = 0;
    rotor.electric->max_current_a = 1e6;
  }
  vehicle.battery->empty_v = vehicle.battery->full_v;
  Bench bench(vehicle);
  const double asked = 900;
  bench.model.set_targets(base::RotorVector::Constant(4, asked));
  const base::ElectricMotor& motor = *vehicle.rotors[0].electric;
  const double tau = 4e-5 * 0.09 / std::pow(motor.torque_constant_nm_a, 2);
  EXPECT_NEAR(motor.lag_s(4e-5, 0, 0), tau, kLastDigits);
  bench.run(0.03, 1e-4);
  EXPECT_NEAR(bench.omega(), asked * (1 - std::exp(-0.03 / tau)), 1e-3);
}

TEST(MotorCircuit, ADisturbedHoverDecaysWithTheLagThatTheLoopsAreDesignedBy) {
  const base::Vehicle vehicle = quad();
  Bench bench(vehicle);
  bench.air.air_density_kg_m3 = vehicle.rotors[0].params.reference_density_kg_m3;
  const double hover = vehicle.rotors[0].speed_at(*vehicle.hover_output(9.80665));
  EXPECT_NEAR(4 * vehicle.rotors[0].params.thrust_coefficient * hover * hover,
              vehicle.mass_kg * 9.80665, 1e-6);
  bench.model.set_targets(base::RotorVector::Constant(4, hover));
  bench.run(1);
  EXPECT_NEAR(bench.omega() / hover, 1, 1e-3) << "the battery is no longer full";
  const double settled = bench.omega();
  bench.forces.states()[0] = settled + 1;
  const double lag_s = vehicle.rotors[0].params.time_constant_up_s;
  bench.run(0.01);
  EXPECT_NEAR(bench.omega() - settled, std::exp(-0.01 / lag_s), 0.01);
}

TEST(MotorCircuit, ChargesGoFromTheBatteryThroughItsResistanceToTheMotors) {
  base::Vehicle vehicle = quad(0.02);
  vehicle.battery->rc_pairs = {base::RcPair{0.01, 0.5}, base::RcPair{0.005, 5}};
  Bench bench(vehicle);
  bench.model.set_targets(base::RotorVector::Constant(4, 600));
  bench.run(3);
  const std::vector<double> x(bench.forces.states().begin(), bench.forces.states().begin() + 7);
  const MotorCircuit::Supply supply = bench.model.supply(x);
  const BatteryReading reading = bench.model.battery(supply, x);
  const double charge = x[4];
  EXPECT_NEAR(supply.voltage_v, 13.2 + 3.6 * charge - x[5] - x[6] - 0.02 * supply.current_a, 1e-9);
  EXPECT_LT(reading.voltage_v, 16.5);
  EXPECT_NEAR(reading.used_ah, 5 * (1 - charge), kLastDigits);
  // Kirchhoff at each motor, and power: what the battery gives the motors take.
  const base::ElectricMotor& motor = *vehicle.rotors[0].electric;
  const double duty = motor.steady_duty(600, vehicle.rotors[0].params.torque_coefficient);
  EXPECT_NEAR(supply.motor_a[0],
              (duty * supply.voltage_v - motor.torque_constant_nm_a * x[0]) / 0.09, 1e-9);
  EXPECT_NEAR(supply.current_a, 4 * duty * supply.motor_a[0], 1e-9);
  // The fast pair has settled, the slow one is on its way.
  EXPECT_NEAR(x[5], 0.01 * supply.current_a, 0.01 * x[5]);
  EXPECT_NEAR(x[6], 0.005 * supply.current_a * (1 - std::exp(-3.0 / 5)), 0.05 * x[6]);
}

TEST(MotorCircuit, LimitsEachMotorsCurrentAndFindsTheVoltageThatGoesWithIt) {
  base::Vehicle vehicle = quad(0.02);
  vehicle.rotors[1].electric->max_current_a = 1000;
  MotorCircuit circuit(vehicle);
  const std::vector<double> omega{0, 300, 600, 0};
  circuit.set_targets(std::vector<double>(4, 5000.0));  // full duty
  const std::vector<double> battery{1, 0, 0};
  const MotorCircuit::Supply supply = circuit.solve(omega, battery, {});
  EXPECT_EQ(supply.motor_a[0], 30);
  EXPECT_GT(supply.motor_a[1], 30);
  EXPECT_NEAR(supply.voltage_v, 16.8 - 0.02 * supply.current_a, 1e-9);
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    sum += supply.motor_a[i];
    EXPECT_EQ(supply.motor_a[i], vehicle.rotors[i].electric->current_a(supply.voltage_v, omega[i]));
  }
  EXPECT_NEAR(sum, supply.current_a, 1e-9);
}

TEST(MotorCircuit, AMotorThatTurnsFasterThanItsDutyFeedsTheBattery) {
  const base::Vehicle vehicle = quad(0.02);
  MotorCircuit circuit(vehicle);
  circuit.set_targets(std::vector<double>(4, 300.0));
  const MotorCircuit::Supply supply =
      circuit.solve(std::vector<double>(4, 700.0), std::vector<double>{0.5, 0, 0}, {});
  EXPECT_LT(supply.current_a, 0);
  EXPECT_GT(supply.voltage_v, 15);
}

TEST(MotorCircuit, AnEmptyBatteryLetsTheRotorsRunDown) {
  base::Vehicle vehicle = quad();
  vehicle.battery->capacity_ah = 0.002;
  Bench bench(vehicle);
  bench.model.set_targets(base::RotorVector::Constant(4, 600));
  bench.run(0.5);
  EXPECT_EQ(bench.forces.states()[4], 0) << "empty";
  const double before = bench.omega();
  bench.run(0.1);
  EXPECT_LT(bench.omega(), 0.9 * before);
  EXPECT_GT(bench.omega(), 0);
  EXPECT_EQ(bench.model.supply({bench.forces.states().data(), 7}).voltage_v, 0);
}

TEST(MotorCircuit, StandsStillWithoutATorqueOnTheBody) {
  Bench bench(quad());
  const Wrench wrench = bench.run(0.1);
  EXPECT_EQ(bench.omega(), 0);
  EXPECT_TRUE(wrench.force_B.isZero(0) && wrench.torque_B.isZero(0));
}

TEST(MotorCircuit, FaultsKeepTheirMeaning) {
  Bench sound(quad());
  const auto settled = [](Bench& bench) {
    bench.model.set_targets(base::RotorVector::Constant(4, 500));
    return bench.run(1);
  };
  const double whole_n = settled(sound).force_B.z();

  Bench broken(quad());  // half of the blades: half the thrust at a speed, and a faster motor
  broken.model.set_effectiveness(Eigen::Vector4d(0.5, 1, 1, 1));
  settled(broken);
  EXPECT_GT(broken.omega(0), sound.omega(0) + 10);
  EXPECT_NEAR(broken.omega(1), sound.omega(1), 0.1);

  Bench turned(quad());  // the wrong way round: the load on the motor stays
  turned.model.set_effectiveness(-Eigen::Vector4d::Ones());
  EXPECT_NEAR(settled(turned).force_B.z(), -whole_n, 1e-6);
  EXPECT_NEAR(turned.omega(), sound.omega(), 1e-6);

  Bench weak(quad());
  weak.model.set_voltage_share(0.8);
  settled(weak);
  EXPECT_LT(weak.omega(), 0.85 * sound.omega());
  EXPECT_GT(weak.omega(), 0.75 * sound.omega());

  Bench struck(quad());
  struck.model.stop(2);
  settled(struck);
  EXPECT_EQ(struck.omega(2), 0);
}

TEST(MotorCircuit, IsIntegratedToAMicrometre) {
  class Spring final : public ForceModel {  // through hover, climb and sink, leaning
   public:
    int state_count() const override { return 0; }
    void initial_states(std::span<double>) const override {}
    void evaluate(const BodyState& body, const Environment&, std::span<const double>,
                  std::span<double>, Wrench& wrench) const override {
      wrench.force_B -= body.q_WB.conjugate() * (20.0 * body.p_WB);
    }
  };
  base::Vehicle vehicle = quad(0.02);
  vehicle.battery->rc_pairs = {base::RcPair{0.01, 0.5}, base::RcPair{0.005, 5}};
  std::vector<double> torques = kPowers;
  for (double& torque : torques) torque /= 2 * M_PI;
  for (base::Rotor& rotor : vehicle.rotors) {
    rotor.propeller = base::Propeller{.diameter_m = 0.254,
                                      .thrust = base::PropellerCurve::table(kRatios, kThrusts),
                                      .torque = base::PropellerCurve::table(kRatios, torques)};
  }
  const auto place = [&](double dt) {
    RotorModel model(vehicle);
    model.set_targets(base::RotorVector::Constant(4, 480));
    const Spring spring;
    ForceSet forces;
    forces.add(model);
    forces.add(spring);
    forces.reset_states();
    std::fill_n(forces.states().begin(), 4, 480.0);  // the limit of the current is a kink
    BodyState body{.v_WB = {2, 0, 3}};
    body.q_WB = Eigen::AngleAxisd(0.1, Vector3d::UnitY());
    Environment air;
    air.gravity_W = {0, 0, -9.80665};
    air.air_density_kg_m3 = 1.225;
    air.height_above_ground_m = 100;
    const MassProperties mass(1, Vector3d(0.03, 0.03, 0.056).asDiagonal());
    for (int i = 0; i < std::lround(10 / dt); ++i) integrate_free(body, forces, mass, air, {}, dt);
    return body.p_WB;
  };
  EXPECT_LT((place(1e-3) - place(5e-4)).norm(), 1e-6);
}

TEST(Battery, FollowsItsCellsCurveAndRecoversAfterALoad) {
  base::BatteryParams params{.full_v = 4.2,
                             .empty_v = 3.3,
                             .capacity_ah = 1,
                             .resistance_ohm = 0.01,
                             .efficiency = 1,
                             .curve = {{0, 3.3}, {0.2, 3.7}, {1, 4.2}}};
  params.rc_pairs[0] = {0.02, 1};
  EXPECT_DOUBLE_EQ(params.open_v(0.1), 3.5);
  EXPECT_DOUBLE_EQ(params.open_v(0.6), 3.95);
  EXPECT_DOUBLE_EQ(params.open_v(1), 4.2);
  BatteryModel battery(params);
  for (int i = 0; i < 5000; ++i) battery.advance(20, 1e-3);
  const double loaded = battery.voltage_v();
  const double open = params.open_v(battery.charge());
  EXPECT_NEAR(loaded, open - 0.03 * battery.current_a(), 2e-3);
  battery.advance(0, 1e-3);
  const double at_once = battery.voltage_v();
  for (int i = 0; i < 5000; ++i) battery.advance(0, 1e-3);
  EXPECT_GT(at_once, loaded + 0.02);
  EXPECT_GT(battery.voltage_v(), at_once + 0.05);
}

}  // namespace
}  // namespace cas::sim
