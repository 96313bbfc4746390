// SPDX-License-Identifier: BSD-3-Clause
// Motors as circuits against measured tables of motors of three makers: CTU Prague, Multi-robot
// Systems group, "Motor tests" (ctu-mrs.github.io, docs/hardware, commit 0428df77). Speed,
// volts and amperes by the ESC (BLHeli_32), at 50 to 100 % throttle in steps of 10 %.
#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <vector>

#include "base/config/propulsion.hpp"

namespace cas::sim {
namespace {

constexpr double kRadPerS = std::numbers::pi / 30;  // of a revolution a minute

/// At one throttle.
struct Measured {
  double rpm, voltage_v, current_a;
};

struct Propeller {
  const char* name;
  double torque_coefficient;  ///< k_m, N m s^2, fitted
  std::array<Measured, 6> rows;
};

/// The speed constant is its maker's; the resistance (with that of ESC and wires) and the current
/// without a load are fitted to all of its propellers.
struct Motor {
  const char* name;
  double kv_rpm_v, resistance_ohm, no_load_current_a;
  std::vector<Propeller> propellers;
};

// clang-format off
const Motor kReadytosky2312{"Readytosky2312", 920, 0.4, 0.2, {
  {"DJI 9450", 1.7e-7, {{{5688, 16.66, 3.09}, {6508, 16.61, 4.80}, {7213, 16.54, 6.72},
    {7788, 16.48, 9.05}, {8608, 16.40, 11.48}, {9068, 16.32, 14.26}}}},
  {"carbon fibre 9450", 1.35e-7, {{{5899, 16.66, 2.80}, {6842, 16.62, 4.27}, {7639, 16.56, 6.09},
    {8448, 16.51, 8.14}, {9125, 16.43, 10.46}, {9708, 16.35, 13.19}}}},
  {"plastic 8045", 1.34e-7, {{{5939, 16.70, 2.73}, {6902, 16.66, 4.17}, {7648, 16.59, 6.06},
    {8499, 16.52, 8.22}, {9076, 16.45, 10.50}, {9722, 16.37, 13.27}}}},
}};
const Motor kTarot4114{"Tarot4114", 320, 0.27, 0, {
  {"Tarot 1555", 1.67e-6, {{{3448, 25.12, 3.60}, {4013, 25.03, 5.77}, {4528, 24.92, 8.53},
    {4975, 24.78, 12.23}, {5468, 24.60, 16.67}, {5832, 24.41, 21.62}}}},
  {"Tarot 1575", 9.94e-7, {{{3624, 25.08, 2.42}, {4277, 25.01, 3.88}, {4836, 24.93, 5.78},
    {5346, 24.82, 8.35}, {5957, 24.69, 11.73}, {6376, 24.52, 15.49}}}},
}};
const Motor kTMotorMn3110{"TMotorMn3110", 780, 0.18, 0.1, {
  {"carbon fibre 1147", 3.27e-7, {{{5313, 16.61, 4.19}, {6156, 16.53, 6.79}, {6971, 16.42, 10.11},
    {7913, 16.29, 13.93}, {8348, 16.13, 18.83}, {8951, 15.95, 24.17}}}},
  {"Tarot 1155", 2.91e-7, {{{5422, 16.53, 3.72}, {6336, 16.45, 6.03}, {7051, 16.36, 9.10},
    {7716, 16.22, 12.96}, {8616, 16.07, 17.42}, {9168, 15.91, 22.97}}}},
  {"Multistar 1045", 2.32e-7, {{{5568, 16.82, 3.41}, {6522, 16.74, 5.47}, {7368, 16.66, 7.98},
    {8345, 16.55, 11.37}, {9136, 16.42, 15.19}, {9836, 16.26, 19.88}}}},
}};
// clang-format on

base::ElectricMotor circuit_of(const Motor& motor, double supply_v) {
  return {.torque_constant_nm_a = 1 / (motor.kv_rpm_v * kRadPerS),
          .resistance_ohm = motor.resistance_ohm,
          .no_load_current_a = motor.no_load_current_a,
          .max_current_a = 1000,
          .supply_v = supply_v};
}

class MotorTable : public testing::TestWithParam<Motor> {};

/// A duty is not quite the throttle, and an ESC's ammeter is no instrument: speeds come within 3 %,
/// currents within 4 %, those of the Readytosky within 11 % (low throttle 10 % low, full 8 % high).
TEST_P(MotorTable, SpeedAndBatteryCurrentFollowFromThrottleAndVoltage) {
  constexpr double kSpeed = 0.03;
  const Motor& motor = GetParam();
  const double current = motor.kv_rpm_v == 920 ? 0.11 : 0.04;
  for (const Propeller& propeller : motor.propellers) {
    for (std::size_t i = 0; i < propeller.rows.size(); ++i) {
      const Measured& row = propeller.rows[i];
      const double duty = 0.5 + 0.1 * static_cast<double>(i);
      const base::ElectricMotor circuit = circuit_of(motor, row.voltage_v);
      const double omega = circuit.steady_speed_rad_s(duty, propeller.torque_coefficient);
      EXPECT_NEAR(omega / (row.rpm * kRadPerS), 1, kSpeed) << propeller.name << " at " << duty;
      const double battery_a = duty * circuit.current_a(duty * row.voltage_v, omega);
      EXPECT_NEAR(battery_a / row.current_a, 1, current) << propeller.name << " at " << duty;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Makers, MotorTable,
                         testing::Values(kReadytosky2312, kTarot4114, kTMotorMn3110),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cas::sim
