// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/vehicle.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "base/config/install_paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

Vehicle load(const std::string& name) {
  return Vehicle::load(find_config("vehicles/" + name + ".yaml"));
}

TEST(VehicleIrisPaper, MixingMatrixIsEquation3) {
  const Vehicle vehicle = load("iris_paper");
  const double k_f = vehicle.rotor.thrust_coefficient;
  const double k_m = vehicle.rotor.torque_coefficient;
  const double l = 0.55 / 2.0 / std::sqrt(2.0);  // l_1 = l_2 from the hub-to-hub diagonal
  Eigen::Matrix4d expected;
  expected << k_f, k_f, k_f, k_f,            //
      -l * k_f, -l * k_f, l * k_f, l * k_f,  //
      l * k_f, -l * k_f, -l * k_f, l * k_f,  //
      -k_m, k_m, -k_m, k_m;
  constexpr double kDigitsInTheFile = 1e-8;
  EXPECT_TRUE(vehicle.mixing_matrix().isApprox(expected, kDigitsInTheFile));
}

TEST(VehicleIrisPx4, SpinsAndOrderAreThoseOfAQuadX) {
  const Vehicle vehicle = load("iris_px4");
  // front right, rear left, front left, rear right; the first two counter-clockwise
  const Eigen::Matrix4d mixer = vehicle.mixing_matrix();
  const Eigen::Matrix4d sign = mixer.cwiseSign();
  Eigen::Matrix4d expected;
  expected << 1, 1, 1, 1,  //
      -1, 1, 1, -1,        // roll right: more thrust on the left
      1, -1, 1, -1,        // nose up: more thrust in front
      1, 1, -1, -1;        // a counter-clockwise rotor turns the body clockwise
  EXPECT_EQ(sign, expected);
}

class ShippedVehicle : public testing::TestWithParam<const char*> {};

TEST_P(ShippedVehicle, ScalesAreWhatTheRotorsCanGive) {
  const Vehicle vehicle = load(GetParam());
  const double omega2 = std::pow(vehicle.rotor.omega_max_rad_s, 2);
  const Eigen::Matrix4d most = vehicle.mixing_matrix() * omega2;
  const Eigen::Vector4d positive = most.cwiseMax(0.0).rowwise().sum();
  constexpr double kDigitsInTheFile = 1e-7;
  EXPECT_NEAR(vehicle.scales.u1_max_n / positive(0), 1.0, kDigitsInTheFile);
  EXPECT_NEAR(vehicle.scales.u2_max_nm / positive(1), 1.0, kDigitsInTheFile);
  EXPECT_NEAR(vehicle.scales.u3_max_nm / positive(2), 1.0, kDigitsInTheFile);
  EXPECT_NEAR(vehicle.scales.u4_max_nm / positive(3), 1.0, kDigitsInTheFile);
}

TEST_P(ShippedVehicle, IsBalancedAndCanHover) {
  const Vehicle vehicle = load(GetParam());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const RotorGeometry& rotor : vehicle.rotors) sum += rotor.position_B_m;
  EXPECT_NEAR(sum.x(), 0.0, 1e-9);
  EXPECT_NEAR(sum.y(), 0.0, 1e-9);
  const double hover = std::sqrt(vehicle.mass_kg * 9.80665 / 4 / vehicle.rotor.thrust_coefficient);
  EXPECT_NEAR(hover, 806, 1);
  EXPECT_LT(hover, vehicle.rotor.omega_max_rad_s);
}

TEST_P(ShippedVehicle, HasAModelFileAndASensorPresetForEachPlugin) {
  const Vehicle vehicle = load(GetParam());
  EXPECT_EQ(vehicle.name, GetParam());
  EXPECT_TRUE(std::filesystem::exists(vehicle.urdf)) << vehicle.urdf;
  for (const char* plugin : {"imu", "gps", "magnetometer", "barometer"}) {
    EXPECT_GT(vehicle.sensors.at(plugin).require<double>("rate_hz"), 0) << plugin;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedVehicle, testing::Values("iris_paper", "iris_px4"),
                         [](const auto& test) { return std::string(test.param); });

TEST(VehicleIrisPaper, SensorPresetIsTable1) {
  const ConfigNode sensors = load("iris_paper").sensors;
  const ConfigNode imu = sensors.at("imu");
  EXPECT_EQ(imu.require<double>("rate_hz"), 500);
  EXPECT_EQ(imu.require<Eigen::Vector3d>("gyro_stddev_deg_s"), Eigen::Vector3d(0.67, 0.78, 0.12));
  EXPECT_EQ(imu.require<Eigen::Vector3d>("accel_stddev_m_s2"), Eigen::Vector3d(0.04, 0.06, 0.07));
  const ConfigNode gps = sensors.at("gps");
  EXPECT_EQ(gps.require<double>("rate_hz"), 5);
  EXPECT_EQ(gps.require<Eigen::Vector3d>("position_stddev_m"), Eigen::Vector3d::Constant(0.3));
}

/// The shipped file with one text replaced.
std::string changed(const std::string& from, const std::string& to) {
  std::ifstream stream(find_config("vehicles/iris_paper.yaml"));
  std::ostringstream text;
  text << stream.rdbuf();
  std::string result = text.str();
  const std::size_t place = result.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return result.replace(place, from.size(), to);
}

struct WrongCase {
  const char* name;
  const char* from;
  const char* to;
  const char* message;
};

class WrongVehicle : public testing::TestWithParam<WrongCase> {};

TEST_P(WrongVehicle, IsRefusedWithItsPlace) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("v.yaml", changed(GetParam().from, GetParam().to));
  try {
    Vehicle::load(file);
    FAIL() << "was accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam().message), std::string::npos)
        << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Fields, WrongVehicle,
    testing::Values(WrongCase{"Schema", "schema: 1", "schema: 2", "schema: is 2"},
                    WrongCase{"MassZero", "mass_kg: 1.55", "mass_kg: 0", "mass_kg: must be above"},
                    WrongCase{"MassMissing", "mass_kg: 1.55", "", "key 'mass_kg' is missing"},
                    WrongCase{"Inertia", "[0.0299559683,", "[0.1,", "inertia_kg_m2: belongs to no"},
                    WrongCase{"Spin", "spin: -1", "spin: 2", "rotors[0].spin: must be 1"},
                    WrongCase{"SystemId", "system_id: 1", "system_id: 256", "system_id: must lie"},
                    WrongCase{"Idle", "omega_idle_rad_s: 100", "omega_idle_rad_s: 2000",
                              "rotor.omega_idle_rad_s: 2000 must lie in [0, 1100]"},
                    WrongCase{"UnknownKey", "system_id: 1", "system_id: 1\nradius: 3",
                              "radius: unknown key"},
                    WrongCase{"Mistyped", "radius_m:", "radus_m:", "did you mean it by 'radus_m'"},
                    WrongCase{"NoDefaultForDrag", "  drag_coefficient: 1.75e-4", "",
                              "rotor: key 'drag_coefficient' is missing"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cas::base
