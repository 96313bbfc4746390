// SPDX-License-Identifier: BSD-3-Clause
// Gains that know the lag of the motors and the delay of the line.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "base/angles.hpp"
#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils::test {
namespace {

using cas::test::TemporaryFolder;

/// A file in the folder for each vehicle. @return that of the vehicle
using VehicleMaker = std::filesystem::path (*)(const TemporaryFolder& folder);

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

/// The shipped quadrotor with motors as slow as those of large propellers.
std::filesystem::path slow_quad(const TemporaryFolder& folder, const std::string& lag_s) {
  const std::string config = cas::test::source_dir() + "/config/vehicles/";
  std::string text = content(config + "quad_x.yaml");
  text = replaced(text, "urdf: quad_x.urdf", "urdf: " + config + "quad_x.urdf");
  text = replaced(text, "time_constant_up_s: 0.02", "time_constant_up_s: " + lag_s);
  text = replaced(text, "time_constant_down_s: 0.03", "time_constant_down_s: " + lag_s);
  return folder.write("slow.yaml", text);
}

/// A quadrotor X whose rotors carry it at two thirds of their full speed.
struct Quad {
  double mass_kg, inertia_kg_m2, yaw_inertia_kg_m2;
  double arm_m;  ///< of a hub, forward and to the side
  double thrust_coefficient, torque_coefficient, omega_max_rad_s;
  double up_s, down_s;
  double rotor_inertia_kg_m2, radius_m, drag_coefficient;
};

std::filesystem::path write_quad(const TemporaryFolder& folder, const Quad& quad) {
  std::ostringstream urdf;
  urdf
      << R"(<?xml version="1.0"?><robot name="quad"><link name="base_link"><inertial><mass value=")"
      << quad.mass_kg << R"("/><inertia ixx=")" << quad.inertia_kg_m2 << R"(" iyy=")"
      << quad.inertia_kg_m2 << R"(" izz=")" << quad.yaw_inertia_kg_m2
      << R"(" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><box size=")"
      << 1.4 * quad.arm_m << " " << 1.4 * quad.arm_m << " " << 0.5 * quad.arm_m
      << R"("/></geometry></collision></link></robot>)";
  folder.write("quad.urdf", urdf.str());
  std::ostringstream yaml;
  yaml << "schema: 1\nname: quad\nurdf: quad.urdf\nsystem_id: 1\nsensors: table1\nrotors:\n";
  for (const auto& [x, y, spin] : {std::tuple{1, -1, 1}, {-1, 1, 1}, {1, 1, -1}, {-1, -1, -1}}) {
    yaml << "  - {position_B_m: [" << x * quad.arm_m << ", " << y * quad.arm_m << ", "
         << 0.3 * quad.arm_m << "], spin: " << spin << "}\n";
  }
  yaml << "rotor:\n  thrust_coefficient: " << quad.thrust_coefficient
       << "\n  torque_coefficient: " << quad.torque_coefficient
       << "\n  omega_max_rad_s: " << quad.omega_max_rad_s
       << "\n  omega_idle_rad_s: " << 0.08 * quad.omega_max_rad_s
       << "\n  time_constant_up_s: " << quad.up_s << "\n  time_constant_down_s: " << quad.down_s
       << "\n  inertia_kg_m2: " << quad.rotor_inertia_kg_m2 << "\n  radius_m: " << quad.radius_m
       << "\n  drag_coefficient: " << quad.drag_coefficient
       << "\n  rolling_moment_coefficient: 0\n  zero_thrust_speed_m_s: 0\n"
          "  reference_density_kg_m3: 0\n  ground_effect: 0\nbody_drag_linear_n_s_m: 0\n";
  return folder.write("quad.yaml", yaml.str());
}

std::filesystem::path small_quad(const TemporaryFolder& folder) {
  return write_quad(folder, {1.5, 0.01815, 0.03375, 0.1768, 5.459e-6, 7.533e-8, 1217, 0.15, 0.225,
                             3.97e-5, 0.115, 1.33e-4});
}

/// Propellers of 1.4 m in diameter.
std::filesystem::path quad_of_100_kg(const TemporaryFolder& folder) {
  return write_quad(
      folder, {100, 43.56, 81, 1.0607, 0.0131, 0.001085, 202.9, 0.08, 0.12, 0.0952, 0.69, 0.0532});
}

/// Propellers of 2.8 m.
std::filesystem::path quad_of_500_kg(const TemporaryFolder& folder) {
  return write_quad(
      folder, {500, 871.2, 1620, 2.1213, 0.262, 0.04339, 101.4, 0.06, 0.09, 1.904, 1.38, 0.5317});
}

/// Largest angle between the vehicle's axis and the vertical, degrees.
double most_tilt_deg(const Flight& flight) {
  const std::vector<double> roll_rad = flight.truth("roll_rad");
  const std::vector<double> pitch_rad = flight.truth("pitch_rad");
  double most_rad = 0;
  for (std::size_t i = 0; i < roll_rad.size(); ++i) {
    most_rad = std::max(most_rad, std::acos(std::cos(roll_rad[i]) * std::cos(pitch_rad[i])));
  }
  return most_rad / base::kRadPerDeg;
}

struct SlowCase {
  const char* name;
  VehicleMaker vehicle;
};

class SlowMotors : public testing::TestWithParam<SlowCase> {};

TEST_P(SlowMotors, FlyToAPlaceHoldAndLand) {
  const TemporaryFolder folder;
  const auto file = folder.write("slow_flight.yaml", R"(schema: 1
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
seed: 1
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
sensors: rtk
line: {preset: baud_921600}
steps:
  - arm
  - takeoff: {altitude_m: 10}
  - goto: {north_m: 20, east_m: 10, up_m: 10, timeout_s: 60}
  - hold: {duration_s: 8}
  - hold: {duration_s: 10, measure: true}
  - land: {timeout_s: 60}
limits: {lost: 0, rms: {x_m: 0.1, y_m: 0.1, z_m: 0.1}}
vehicle: )" + GetParam().vehicle(folder).string() + "\n");
  const Flight flight(Scenario::load(file), 1, "slow_motors");
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
  EXPECT_LT(most_tilt_deg(flight), 30);
}

INSTANTIATE_TEST_SUITE_P(
    All, SlowMotors,
    testing::Values(
        SlowCase{"QuadOf50ms", [](const auto& folder) { return slow_quad(folder, "0.05"); }},
        SlowCase{"QuadOf80ms", [](const auto& folder) { return slow_quad(folder, "0.08"); }},
        SlowCase{"QuadOf150ms", [](const auto& folder) { return slow_quad(folder, "0.15"); }},
        SlowCase{"QuadOf200ms", [](const auto& folder) { return slow_quad(folder, "0.20"); }},
        SlowCase{"SmallQuadOf150msUp225msDown", small_quad},
        SlowCase{"QuadOf100kg", quad_of_100_kg}, SlowCase{"QuadOf500kg", quad_of_500_kg}),
    [](const auto& test) { return test.param.name; });

class SlowLine : public testing::TestWithParam<const char*> {};

/// HIL_SENSOR fills two thirds of this line upwards. Downwards the controls and all telemetry are
/// more than it carries; and it delays the rate loops by 44 ms.
TEST_P(SlowLine, Of57600BaudCarriesTheControlsFirst) {
  const TemporaryFolder folder;
  const auto file = folder.write("slow_line.yaml", R"(schema: 1
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
seed: 1
rates: {sensor_hz: 50, gps_hz: 5, controls_hz: 50}
sensors: rtk
line: {preset: baud_115200, baud: 57600}
steps:
  - arm
  - takeoff: {altitude_m: 5}
  - goto: {north_m: 10, east_m: 0, up_m: 5, timeout_s: 60}
  - hold: {duration_s: 8}
  - hold: {duration_s: 10, measure: true}
  - land: {timeout_s: 60}
limits: {lost: 0, rms: {x_m: 0.2, y_m: 0.2, z_m: 0.2}}
vehicle: )" + cas::test::source_dir() + "/config/vehicles/" +
                                                       GetParam() + ".yaml\n");
  const Flight flight(Scenario::load(file), 1, "slow_line");
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
  EXPECT_LT(most_tilt_deg(flight), 30);
}

/// HIL_CONTROLS, and HIL_ACTUATOR_CONTROLS, which is twice as long.
INSTANTIATE_TEST_SUITE_P(All, SlowLine, testing::Values("iris_paper", "hexa_x"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace cas::hils::test
