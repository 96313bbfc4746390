// SPDX-License-Identifier: BSD-3-Clause
// The blocks `propeller`, `electric` and `battery` of a vehicle file.
#include <gmock/gmock.h>

#include <cmath>
#include <string>

#include "base/config/vehicle.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

using testing::HasSubstr;

constexpr const char* kPropeller = "propeller: {diameter_m: 0.254, CT: [0.12, -0.1], CP: [0.05]}";
constexpr const char* kElectric =
    "electric: {kv_rpm_v: 700, resistance_ohm: 0.09, no_load_current_a: 0.7, max_current_a: 30}";
constexpr const char* kBattery =
    "battery: {full_v: 16.8, empty_v: 13.2, capacity_ah: 5, resistance_ohm: 0.02}\n";
constexpr const char* kCoefficients =
    "thrust_coefficient: 1.0e-5, torque_coefficient: 2.0e-7, radius_m: 0.1, "
    "zero_thrust_speed_m_s: 0";
constexpr const char* kLag =
    "omega_max_rad_s: 900, time_constant_up_s: 0.02, time_constant_down_s: 0.03";

/// A vehicle of two rotors whose model is not there.
/// @param rotor  keys of all rotors beside those that no block replaces
/// @param own    more keys of the second rotor
std::string two_rotors(const std::string& rotor, const std::string& own = "",
                       const std::string& rest = "") {
  return R"(schema: 1
name: two
urdf: nowhere.urdf
mass_kg: 1
inertia_kg_m2: [0.02, 0.02, 0.03]
body_drag_linear_n_s_m: 0
system_id: 1
rotor: {omega_idle_rad_s: 0, inertia_kg_m2: 4.0e-5, drag_coefficient: 0,
  rolling_moment_coefficient: 0, reference_density_kg_m3: 1.2, ground_effect: 0, )" +
         rotor + R"(}
rotors:
  - {position_B_m: [0.1, 0, 0], spin: 1}
  - {position_B_m: [-0.1, 0, 0], spin: -1)" +
         (own.empty() ? "" : ", " + own) + "}\n" + rest;
}

Vehicle load_text(const std::string& text) {
  const cas::test::TemporaryFolder folder;
  return Vehicle::load(folder.write("v.yaml", text));
}

TEST(PropulsionFile, APropellerGivesTheStaticCoefficients) {
  const Vehicle vehicle = load_text(two_rotors(std::string(kPropeller) + ", " + kLag));
  const RotorParams& params = vehicle.rotors[0].params;
  ASSERT_TRUE(vehicle.rotors[1].propeller);
  constexpr double kRounding = 1e-15;
  const double per_turn = 4 * M_PI * M_PI;
  EXPECT_NEAR(params.thrust_coefficient, 1.2 * std::pow(0.254, 4) * 0.12 / per_turn, kRounding);
  EXPECT_NEAR(params.torque_coefficient, 1.2 * std::pow(0.254, 5) * 0.05 / (2 * M_PI) / per_turn,
              kRounding);
  EXPECT_EQ(params.radius_m, 0.127);
  EXPECT_EQ(params.zero_thrust_speed_m_s, 0);
}

TEST(PropulsionFile, ARotorMayHaveAPropellerOfItsOwn) {
  const Vehicle vehicle =
      load_text(two_rotors(std::string(kCoefficients) + ", " + kLag, kPropeller));
  EXPECT_FALSE(vehicle.rotors[0].propeller);
  EXPECT_EQ(vehicle.rotors[0].params.thrust_coefficient, 1e-5);
  EXPECT_TRUE(vehicle.rotors[1].propeller);
}

TEST(PropulsionFile, ATableIsInTheFileOrInUiucsColumns) {
  const cas::test::TemporaryFolder folder;
  folder.write("apc.txt",
               "J CT CP eta\n  0.1   0.11  0.05  0.2\n\n0.4 0.07 0.04 0.6\n0.7 0 0.02 0\n");
  const auto load_with = [&](const std::string& source) {
    return Vehicle::load(folder.write(
        "v.yaml", two_rotors("propeller: {diameter_m: 0.254, " + source + "}, " + kLag)));
  };
  const Vehicle file = load_with("file: apc.txt");
  const Vehicle list = load_with("table: [[0.1, 0.11, 0.05], [0.4, 0.07, 0.04], [0.7, 0, 0.02]]");
  for (const double j : {-0.5, 0.0, 0.2, 0.4, 0.9}) {
    EXPECT_EQ(file.rotors[0].propeller->thrust.scaled(1, j),
              list.rotors[0].propeller->thrust.scaled(1, j));
    EXPECT_EQ(file.rotors[0].propeller->torque.scaled(1, j),
              list.rotors[0].propeller->torque.scaled(1, j));
  }
  EXPECT_NEAR(list.rotors[0].propeller->thrust.scaled(2, 0.8), 4 * 0.07, 1e-15);
  folder.write("bad.txt", "J CT CP\n0.1 0.11 0.05\n0.2 0.1\n");
  EXPECT_THAT(cas::test::refusal([&] { load_with("file: bad.txt"); }),
              HasSubstr("bad.txt:3: must have three numbers, J, CT and CP"));
  folder.write("static.txt", "RPM CT CP\n1500 0.11 0.05\n");
  EXPECT_THAT(cas::test::refusal([&] { load_with("file: static.txt"); }),
              HasSubstr("static.txt:2: has no advance"));
}

TEST(PropulsionFile, ACircuitGivesFastestSpeedAndLag) {
  const Vehicle vehicle =
      load_text(two_rotors(std::string(kPropeller) + ", " + kElectric, "", kBattery));
  const Rotor& rotor = vehicle.rotors[0];
  ASSERT_TRUE(rotor.electric);
  EXPECT_EQ(rotor.electric->supply_v, 16.8);
  EXPECT_NEAR(
      rotor.electric->steady_duty(rotor.params.omega_max_rad_s, rotor.params.torque_coefficient), 1,
      1e-12);
  const double output = *vehicle.hover_output(9.80665);
  const double omega = rotor.speed_at(output);
  EXPECT_NEAR(2 * rotor.params.thrust_coefficient * omega * omega, 9.80665, 1e-9);
  EXPECT_NEAR(rotor.output_at(omega), output, 1e-12);
  EXPECT_EQ(rotor.params.time_constant_up_s, rotor.params.time_constant_down_s);
  EXPECT_NEAR(rotor.params.time_constant_up_s,
              rotor.electric->lag_s(4e-5, rotor.params.torque_coefficient, omega), 1e-12);
}

TEST(PropulsionFile, ABatteryMayBeOfCellsWithACurveAndRcPairs) {
  const std::string cells =
      "battery: {cells: 4, cell_v: [[0, 3.3], [0.1, 3.7], [1, 4.2]], capacity_ah: 5, "
      "resistance_ohm: 0.02, rc_pairs: [{resistance_ohm: 0.01, time_constant_s: 3}]}\n";
  const Vehicle vehicle =
      load_text(two_rotors(std::string(kPropeller) + ", " + kElectric, "", cells));
  const BatteryParams& battery = *vehicle.battery;
  EXPECT_DOUBLE_EQ(battery.full_v, 16.8);
  EXPECT_DOUBLE_EQ(battery.empty_v, 13.2);
  EXPECT_DOUBLE_EQ(battery.open_v(0.05), 14);
  EXPECT_EQ(battery.rc_pairs[0].time_constant_s, 3);
  EXPECT_EQ(battery.rc_pairs[1].resistance_ohm, 0);
}

std::string with_propeller(const std::string& keys) {
  return two_rotors("propeller: {" + keys + "}, " + kLag);
}
std::string with_battery(const std::string& keys) {
  return two_rotors(std::string(kPropeller) + ", " + kElectric, "", "battery: {" + keys + "}\n");
}

TEST(WrongPropulsion, IsRefusedInOneSentence) {
  struct PropulsionCase {
    const char* name;
    std::string text;
    const char* message;
  };
  const PropulsionCase rows[] = {
      {"Both", two_rotors(std::string(kPropeller) + ", thrust_coefficient: 1.0e-5, " + kLag),
       "rotor.thrust_coefficient: is given by the block `propeller`"},
      {"OwnBesideCommon", two_rotors(std::string(kPropeller) + ", " + kLag, "radius_m: 0.1"),
       "rotors[1].radius_m: is given by the block `propeller`"},
      {"NoDiameter", with_propeller("CT: [0.1], CQ: [0.01]"), "key 'diameter_m' is missing"},
      {"TwoSources", with_propeller("diameter_m: 1, CT: [0.1], table: []"),
       "must have one of `table`, `file`, and `CT`"},
      {"NoTorque", with_propeller("diameter_m: 1, CT: [0.1]"), "must have one of `CQ` and `CP`"},
      {"Cubic", with_propeller("diameter_m: 1, CT: [1, 0, 0, -1], CP: [0.1]"),
       "propeller.CT: must have one to three coefficients"},
      {"NoThrust", with_propeller("diameter_m: 1, CT: [0, 1, -1], CP: [0.1]"),
       "has a CT of 0.000000 in still air"},
      {"Rises", with_propeller("diameter_m: 1, CT: [0.1, 0, 0.1], CP: [0.1]"),
       "has a CT that rises at the end"},
      {"Order", with_propeller("diameter_m: 1, table: [[0.1, 0.1, 0.1], [0.1, 0, 0]]"),
       "propeller.table[1]: must have a larger advance ratio"},
      {"NoFile", with_propeller("diameter_m: 1, file: none.txt"), "none.txt, which cannot be read"},
      {"Inflow", two_rotors(std::string(kPropeller) + ", inflow_thrust_slope: 0.7, " + kLag),
       "and so does inflow_thrust_slope"},
      {"NoBattery", two_rotors(std::string(kPropeller) + ", " + kElectric),
       "electric: needs a `battery`"},
      {"LagBesideCircuit",
       two_rotors(std::string(kPropeller) + ", omega_max_rad_s: 900, " + kElectric, "", kBattery),
       "rotor.omega_max_rad_s: is given by the block `electric`"},
      {"OneWithCircuit", two_rotors(std::string(kCoefficients) + ", " + kLag, kElectric, kBattery),
       "rotors[1]: has a motor of another kind than rotor 1"},
      {"NoCurrent",
       two_rotors(std::string(kPropeller) + ", electric: {kv_rpm_v: 700, resistance_ohm: 0.1}", "",
                  kBattery),
       "'rotor.electric.no_load_current_a', 'rotor.electric.max_current_a'"},
      {"Stiff",
       two_rotors(std::string(kPropeller) + ", electric: {kv_rpm_v: 100, resistance_ohm: 0.01, "
                                            "no_load_current_a: 1, max_current_a: 100}",
                  "", kBattery),
       "below 2 ms it cannot be integrated"},
      {"Efficiency",
       with_battery("full_v: 16, empty_v: 12, capacity_ah: 5, resistance_ohm: 0, efficiency: 0.9"),
       "battery.efficiency: is for rotors without `electric`"},
      {"CellsAndVolts",
       with_battery(
           "cells: 4, cell_v: [[0, 3], [1, 4]], full_v: 16, capacity_ah: 5, resistance_ohm: 0"),
       "battery.full_v: is given by cell_v"},
      {"HalfACurve",
       with_battery("cells: 4, cell_v: [[0.5, 3], [1, 4]], capacity_ah: 5, resistance_ohm: 0"),
       "from charge 0 to 1"},
      {"ThreePairs",
       with_battery(
           "full_v: 16, empty_v: 12, capacity_ah: 5, resistance_ohm: 0, rc_pairs: [{}, {}, {}]"),
       "battery.rc_pairs: has more than two pairs"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_THAT(cas::test::refusal([&] { load_text(row.text); }), HasSubstr(row.message));
  }
}

}  // namespace
}  // namespace cas::base
