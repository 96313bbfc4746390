// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/vehicle.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "base/config/install_paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

using testing::HasSubstr;
using testing::Not;

Vehicle load(const std::string& name) {
  return Vehicle::load(find_config("vehicles/" + name + ".yaml"));
}

TEST(VehicleIrisPaper, MixingMatrixIsEquation3) {
  const Vehicle vehicle = load("iris_paper");
  const double k_f = vehicle.rotors[0].params.thrust_coefficient;
  const double k_m = vehicle.rotors[0].params.torque_coefficient;
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
  const double omega2 = std::pow(vehicle.rotors[0].params.omega_max_rad_s, 2);
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
  for (const Rotor& rotor : vehicle.rotors) sum += rotor.position_B_m;
  EXPECT_NEAR(sum.x(), 0.0, 1e-9);
  EXPECT_NEAR(sum.y(), 0.0, 1e-9);
  const double hover =
      std::sqrt(vehicle.mass_kg * 9.80665 / 4 / vehicle.rotors[0].params.thrust_coefficient);
  EXPECT_NEAR(hover, 806, 1);
  EXPECT_LT(hover, vehicle.rotors[0].params.omega_max_rad_s);
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

TEST(WrongVehicle, IsRefusedWithItsPlace) {
  struct WrongCase {
    const char* name;
    const char* from;
    const char* to;
    const char* message;
  };
  const WrongCase rows[] = {
      {"Schema", "schema: 1", "schema: 2", "schema: is 2"},
      {"MassZero", "mass_kg: 1.55", "mass_kg: 0", "mass_kg: must be above"},
      {"MassMissing", "mass_kg: 1.55", "", "key 'mass_kg' is missing"},
      {"Inertia", "[0.0299559683,", "[0.1,", "inertia_kg_m2: belongs to no"},
      {"Spin", "spin: -1", "spin: 2", "rotors[0].spin: must be 1"},
      {"SpinByWord", "spin: -1", "spin: ccw", "rotors[0].spin: must be 1"},
      {"SystemId", "system_id: 1", "system_id: 256", "system_id: must lie"},
      {"Idle", "omega_idle_rad_s: 100", "omega_idle_rad_s: 2000",
       "rotor.omega_idle_rad_s: 2000 must lie in [0, 1100]"},
      {"UnknownKey", "system_id: 1", "system_id: 1\nradius: 3", "radius: unknown key"},
      {"Mistyped", "radius_m:", "radus_m:", "did you mean it by 'radus_m'"},
      {"NoDefaultForDrag", "  drag_coefficient: 1.75e-4", "",
       "rotor: key 'drag_coefficient' is missing"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const test::TemporaryFolder folder;
    const auto file = folder.write("v.yaml", changed(row.from, row.to));
    EXPECT_THAT(test::refusal([&] { Vehicle::load(file); }), HasSubstr(row.message));
  }
}

TEST(VehicleFile, NamesAllMissingKeysInOneSentence) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("v.yaml", R"(
schema: 1
name: mine
urdf: nowhere.urdf
rotors:
  - {position_B_m: [0.1, 0, 0], spin: 1, radius_m: 0.1}
  - {spin: -1}
rotor: {thrust_coefficient: 1.0e-5, omega_max_rad_s: 900}
scales: {u1_max_n: 10}
)");
  const std::string text = test::refusal([&] { Vehicle::load(file); });
  EXPECT_EQ(text.find(file.string()), 0U) << text;
  for (const char* key : {"'system_id'", "'body_drag_linear_n_s_m'", "'mass_kg'", "'inertia_kg_m2'",
                          "'rotor.torque_coefficient'", "'rotor.ground_effect'", "'rotor.radius_m'",
                          "'rotors[1].position_B_m'", "'scales.u2_max_nm'", "'scales.u4_max_nm'"}) {
    EXPECT_THAT(text, HasSubstr(key)) << key << " in " << text;
  }
  EXPECT_THAT(text, Not(HasSubstr("thrust_coefficient")));
}

TEST(VehicleFile, ScalesAreComputedWhereTheyAreLeftOut) {
  const test::TemporaryFolder folder;
  std::string text = changed("urdf: iris_paper.urdf", "urdf: nowhere.urdf");
  const std::size_t begin = text.find("scales:");
  text.erase(begin, text.find("body_drag") - begin);
  const Vehicle computed = Vehicle::load(folder.write("v.yaml", text));
  const Vehicle given = load("iris_paper");
  constexpr double kDigitsInTheFile = 1e-7;
  EXPECT_NEAR(computed.scales.u1_max_n / given.scales.u1_max_n, 1, kDigitsInTheFile);
  EXPECT_NEAR(computed.scales.u2_max_nm / given.scales.u2_max_nm, 1, kDigitsInTheFile);
  EXPECT_NEAR(computed.scales.u3_max_nm / given.scales.u3_max_nm, 1, kDigitsInTheFile);
  EXPECT_NEAR(computed.scales.u4_max_nm / given.scales.u4_max_nm, 1, kDigitsInTheFile);
}

/// A vehicle of any number of rotors on a circle whose model is not there.
std::string round_vehicle(int rotors, const std::string& keys_of_rotor_2 = "") {
  std::string text = R"(schema: 1
name: round
urdf: nowhere.urdf
mass_kg: 2
inertia_kg_m2: [0.02, 0.02, 0.03]
body_drag_linear_n_s_m: 0
system_id: 1
rotor: {thrust_coefficient: 1.0e-5, torque_coefficient: 2.0e-7, omega_max_rad_s: 900,
  omega_idle_rad_s: 100, time_constant_up_s: 0.02, time_constant_down_s: 0.03,
  inertia_kg_m2: 3.0e-5, radius_m: 0.1, drag_coefficient: 0, rolling_moment_coefficient: 0,
  zero_thrust_speed_m_s: 0, reference_density_kg_m3: 0, ground_effect: 0}
rotors:
)";
  for (int i = 0; i < rotors; ++i) {
    const double angle = 2 * M_PI * i / rotors;
    text += "  - {position_B_m: [" + std::to_string(std::cos(angle)) + ", " +
            std::to_string(std::sin(angle)) + ", 0], spin: " + (i % 2 == 0 ? "1" : "-1") +
            (i == 1 ? keys_of_rotor_2 : "") + "}\n";
  }
  return text;
}

Vehicle load_round(int rotors, const std::string& keys_of_rotor_2 = "") {
  const test::TemporaryFolder folder;
  return Vehicle::load(folder.write("v.yaml", round_vehicle(rotors, keys_of_rotor_2)));
}

TEST(VehicleFile, RotorsThatNameLinksNeedTheirModel) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("v.yaml", round_vehicle(3, ", link: prop_1"));
  EXPECT_THAT(test::refusal([&] { Vehicle::load(file); }),
              HasSubstr("urdf: there is no file " + (folder / "nowhere.urdf").string() +
                        ", whose link 'prop_1' a rotor names"));
}

TEST(VehicleFile, HasOneToSixteenRotors) {
  for (const int count : {1, 2, 3, 4, 5, 6, 8, 12, 16}) {
    const Vehicle vehicle = load_round(count);
    EXPECT_EQ(vehicle.rotor_count(), count);
    EXPECT_EQ(vehicle.effectiveness().cols(), count);
    EXPECT_EQ(vehicle.rotors.back().output, count - 1);
  }
  for (const int count : {0, 17}) EXPECT_THROW(load_round(count), ConfigError);
}

TEST(VehicleFile, ARotorsOwnKeysGoBeforeTheCommonOnes) {
  const Vehicle vehicle =
      load_round(3,
                 ", thrust_coefficient: 3.0e-5, axis_B: [0, 3, 4], output: 9, "
                 "in_wake_of: 3, wake_thrust_share: 0.8, tilt: {axis_B: [2, 0, 0], "
                 "min_deg: -90, max_deg: 45, rate_deg_s: 360, time_constant_s: "
                 "0.05, output: 4}");
  EXPECT_EQ(vehicle.rotors[0].params.thrust_coefficient, 1e-5);
  const Rotor& own = vehicle.rotors[1];
  EXPECT_EQ(own.params.thrust_coefficient, 3e-5);
  EXPECT_EQ(own.params.torque_coefficient, 2e-7);
  EXPECT_TRUE(own.axis_B.isApprox(Eigen::Vector3d(0, 0.6, 0.8)));
  EXPECT_EQ(own.output, 8);
  ASSERT_TRUE(own.wake && own.tilt);
  EXPECT_EQ(own.wake->upper, 2);
  EXPECT_EQ(own.wake->thrust_share, 0.8);
  EXPECT_EQ(own.tilt->axis_B, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(own.tilt->min_rad, -M_PI / 2, 1e-12);
  EXPECT_NEAR(own.tilt->angle_rad(0.5), M_PI / 8, 1e-12);
  EXPECT_NEAR(own.tilt->angle_rad(-0.5), -M_PI / 4, 1e-12);
  EXPECT_NEAR(own.tilt->rate_rad_s, 2 * M_PI, 1e-12);
  EXPECT_EQ(own.tilt->output, 3);
}

TEST(TiltServo, RunsFromItsMiddleToBothEnds) {
  const TiltServo uneven{.min_rad = -0.2, .max_rad = 1.5, .middle_rad = 0.5};
  EXPECT_NEAR(uneven.angle_rad(-1), -0.2, 1e-12);
  EXPECT_NEAR(uneven.angle_rad(-0.5), 0.15, 1e-12);
  EXPECT_NEAR(uneven.angle_rad(0), 0.5, 1e-12);
  EXPECT_NEAR(uneven.angle_rad(0.5), 1.0, 1e-12);
  for (const double output : {-1.0, -0.3, 0.0, 0.6, 1.0}) {
    EXPECT_NEAR(uneven.output_at(uneven.angle_rad(output)), output, 1e-12);
  }
  EXPECT_EQ(uneven.output_at(-1), -1);
  EXPECT_EQ(uneven.output_at(2), 1);
  const TiltServo one_way{.max_rad = 1};
  EXPECT_EQ(one_way.angle_rad(-1), 0);
  EXPECT_EQ(one_way.output_at(-0.1), 0);
}

TEST(VehicleFile, ATiltServoMayStandAnywhereWithinItsEndsAtOutput0) {
  const Vehicle vehicle =
      load_round(3,
                 ", tilt: {axis_B: [0, 1, 0], min_deg: 0, middle_deg: 45, max_deg: "
                 "90, rate_deg_s: 200, time_constant_s: 0.05, output: 4}");
  const Rotor& rotor = vehicle.rotors[1];
  const auto axis = [&](double output) {
    return rotor.tilted_axis_B(rotor.tilt->angle_rad(output));
  };
  EXPECT_TRUE(axis(-1).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(axis(0).isApprox(Eigen::Vector3d(1, 0, 1).normalized(), 1e-12));
  EXPECT_TRUE(axis(1).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
}

TEST(WrongRotor, IsRefusedWithItsPlace) {
  struct RotorCase {
    const char* keys;
    const char* message;
  };
  const RotorCase rows[] = {{", axis_B: [0, 0, 0]", "rotors[1].axis_B: is a direction"},
                            {", output: 17", "rotors[1].output: must lie in [1, 16]"},
                            {", output: 1", "rotors[1]: output 1 drives something else"},
                            {", in_wake_of: 2, wake_thrust_share: 1", "number of another rotor"},
                            {", in_wake_of: 4, wake_thrust_share: 1", "number of another rotor"},
                            {", in_wake_of: 1", "key 'wake_thrust_share' is missing"},
                            {", tilt: {axis_B: [1, 0, 0], output: 4}",
                             "'rotors[1].tilt.min_deg', 'rotors[1].tilt.max_deg'"},
                            {", tilt: {axis_B: [0, 1, 0], min_deg: 0, middle_deg: 95, max_deg: 90, "
                             "rate_deg_s: 200, time_constant_s: 0.05, output: 4}",
                             "rotors[1].tilt.middle_deg: 95 must lie in [0, 90]"},
                            {", inflow_thrust_slope: 1.3, zero_thrust_speed_m_s: 20",
                             "rotors[1].inflow_thrust_slope: takes thrust by the axial airspeed"},
                            {", esc_dead_time_s: 1", "rotors[1].esc_dead_time_s: 1 must lie in"},
                            {", raduis_m: 1", "rotors[1].raduis_m: unknown key"},
                            {", link: prop", "nowhere.urdf, whose link 'prop' a rotor names"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.keys);
    EXPECT_THAT(test::refusal([&] { load_round(3, row.keys); }), HasSubstr(row.message));
  }
}

TEST(Vehicle, ReadsTheDragOfItsBody) {
  const test::TemporaryFolder folder;
  const auto load = [&](const std::string& drag) {
    return Vehicle::load(folder.write("v.yaml", round_vehicle(3) + drag));
  };
  EXPECT_FALSE(load("").body_drag);
  const auto drag = load("body_drag: {area_m2: [0.01, 0.02, 0.04]}\n").body_drag;
  ASSERT_TRUE(drag);
  EXPECT_EQ(drag->area_m2, Eigen::Vector3d(0.01, 0.02, 0.04));
  EXPECT_EQ(drag->centre_B_m, Eigen::Vector3d::Zero());
  EXPECT_EQ(
      load("body_drag: {area_m2: [0, 0, 1], centre_B_m: [0, 0, -0.1]}\n").body_drag->centre_B_m,
      Eigen::Vector3d(0, 0, -0.1));
  const auto npos = std::string::npos;
  EXPECT_NE(test::refusal([&] {
              load("body_drag: {area_m2: [0, -1, 0]}\n");
            }).find("body_drag.area_m2: must be three numbers, none below 0"),
            npos);
  EXPECT_NE(test::refusal([&] {
              load("body_drag: {}\n");
            }).find("v.yaml:16: body_drag: key 'area_m2' is missing"),
            npos);
  EXPECT_NE(test::refusal([&] {
              load("body_drag: {area_m2: [0, 0, 0], cp: 1}\n");
            }).find("body_drag.cp: unknown key"),
            npos);
}

TEST(FourRotors, AreRefusedWhereEquation3HasNoInverse) {
  struct SingularCase {
    const char* rotors;
    const char* missing;  ///< the dependent quantity; nullptr: none
  };
  const SingularCase rows[] = {
      {"[{position_B_m: [0, 0.3, 0], spin: 1}, {position_B_m: [0, 0.1, 0], "
       "spin: -1}, {position_B_m: [0, -0.1, 0], spin: 1}, {position_B_m: [0, "
       "-0.3, 0], spin: -1}]\n",
       "pitch moment"},
      {"[{position_B_m: [0.3, 0.3, 0], spin: 1}, {position_B_m: [0.1, "
       "0.1, 0], spin: -1}, {position_B_m: [-0.1, -0.1, 0], spin: 1}, "
       "{position_B_m: [-0.3, -0.3, 0], spin: -1}]\n",
       "pitch moment"},
      {"[{position_B_m: [0.2, 0.2, 0], spin: 1}, {position_B_m: [0.2, "
       "-0.2, 0], spin: 1}, {position_B_m: [-0.2, 0.2, 0], spin: 1}, "
       "{position_B_m: [-0.2, -0.2, 0], spin: 1}]\n",
       "yaw moment"},
      {"[{position_B_m: [0.2, 0.2, 0], spin: 1}, {position_B_m: "
       "[0.2, -0.2, 0], spin: -1}, {position_B_m: [-0.2, 0.2, 0], "
       "spin: 1}, {position_B_m: [-0.2, -0.2, 0], spin: -1}]\n",
       "yaw moment"},
      {"[{position_B_m: [0.2, 0.2, 0], spin: 1}, {position_B_m: [0.2, -0.2, "
       "0], spin: -1}, {position_B_m: [-0.2, 0.2, 0], spin: -1}, "
       "{position_B_m: [-0.2, -0.2, 0], spin: 1}]\n",
       nullptr}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.rotors);
    const test::TemporaryFolder folder;
    const std::string whole = round_vehicle(1);
    const auto file =
        folder.write("v.yaml", whole.substr(0, whole.find("rotors:")) + "rotors: " + row.rotors);
    if (row.missing == nullptr) {
      EXPECT_NO_THROW(Vehicle::load(file));
      continue;
    }
    EXPECT_THAT(
        test::refusal([&] { Vehicle::load(file); }),
        HasSubstr(std::string("v.yaml:12: rotors: places and spins of the four rotors leave no "
                              "independent ") +
                  row.missing));
  }
}

// One description: the model and the vehicle file.

/// A quad's model with its rotors at `arm`, one leaning, the body's centre of gravity aside.
std::string quad_model(double arm, double lean_rad, double mass, double inertia, double cog_x,
                       int rotors = 4) {
  std::string text = "<robot name='q'>\n<link name='base_link'>\n<inertial><origin xyz='" +
                     std::to_string(cog_x) + " 0 0'/><mass value='" + std::to_string(mass) +
                     "'/><inertia ixx='" + std::to_string(inertia) + "' iyy='" +
                     std::to_string(inertia) + "' izz='" + std::to_string(1.5 * inertia) +
                     "' ixy='0' ixz='0' iyz='0'/></inertial></link>\n";
  const double places[6][2] = {{1, -1}, {-1, 1}, {1, 1}, {-1, -1}, {2, 0}, {-2, 0}};
  for (int i = 0; i < rotors; ++i) {
    const std::string name = "prop_" + std::to_string(i + 1);
    text += "<link name='" + name + "'/><joint name='j" + std::to_string(i) +
            "' type='continuous'><origin xyz='" + std::to_string(arm * places[i][0]) + " " +
            std::to_string(arm * places[i][1]) + " 0.02' rpy='" +
            std::to_string(i == 0 ? lean_rad : 0.0) +
            " 0 0'/><parent link='base_link'/><child link='" + name +
            "'/><axis xyz='0 0 -1'/></joint>\n";
  }
  return text + "</robot>\n";
}

constexpr const char* kQuadRest = R"(
schema: 1
name: q
urdf: q.urdf
body_drag_linear_n_s_m: 0
system_id: 1
rotor: {thrust_coefficient: 1.0e-5, torque_coefficient: 2.0e-7, omega_max_rad_s: 900,
  omega_idle_rad_s: 100, time_constant_up_s: 0.02, time_constant_down_s: 0.03,
  inertia_kg_m2: 3.0e-5, radius_m: 0.1, drag_coefficient: 0, rolling_moment_coefficient: 0,
  zero_thrust_speed_m_s: 0, reference_density_kg_m3: 0, ground_effect: 0}
)";

TEST(OneDescription, WhatTheFileLeavesOutIsTheModels) {
  const test::TemporaryFolder folder;
  folder.write("q.urdf", quad_model(0.2, 0.3, 1.2, 0.02, 0.01));
  const Vehicle vehicle = Vehicle::load(
      folder.write("q.yaml", std::string(kQuadRest) + "rotors: [{link: prop_3, spin: 1}, {link: "
                                                      "prop_1, spin: -1}, {link: prop_2, spin: 1}, "
                                                      "{link: prop_4, spin: -1}]\n"));
  constexpr double kDigitsInTheFile = 1e-6;
  EXPECT_NEAR(vehicle.mass_kg, 1.2, kDigitsInTheFile);
  EXPECT_TRUE(vehicle.inertia_kg_m2.isApprox(Eigen::Vector3d(0.02, 0.02, 0.03), kDigitsInTheFile));
  // From the centre of gravity, which is 10 mm ahead of the root link's origin.
  EXPECT_TRUE(
      vehicle.rotors[0].position_B_m.isApprox(Eigen::Vector3d(0.19, 0.2, 0.02), kDigitsInTheFile));
  EXPECT_EQ(vehicle.rotors[0].axis_B, Eigen::Vector3d::UnitZ()) << "thrust is upwards";
  EXPECT_TRUE(vehicle.rotors[1].axis_B.isApprox(Eigen::Vector3d(0, -std::sin(0.3), std::cos(0.3)),
                                                kDigitsInTheFile));
}

/// The same quad as an SDF file, an element a line.
std::string quad_sdf(double arm, double lean_rad, double mass, double inertia, double cog_x) {
  const auto text_of = [](double value) { return std::to_string(value); };
  std::string text =
      "<sdf version='1.9'>\n<model name='q'>\n<link name='base_link'>\n<inertial>"
      "<pose>" +
      text_of(cog_x) + " 0 0 0 0 0</pose><mass>" + text_of(mass) + "</mass><inertia><ixx>" +
      text_of(inertia) + "</ixx><iyy>" + text_of(inertia) + "</iyy><izz>" + text_of(1.5 * inertia) +
      "</izz></inertia></inertial></link>\n";
  const double places[4][2] = {{1, -1}, {-1, 1}, {1, 1}, {-1, -1}};
  for (int i = 0; i < 4; ++i) {
    const std::string name = "prop_" + std::to_string(i + 1);
    text += "<link name='" + name + "'><pose>" + text_of(arm * places[i][0]) + " " +
            text_of(arm * places[i][1]) + " 0.02 " + text_of(i == 0 ? lean_rad : 0.0) +
            " 0 0</pose><inertial><mass>0</mass><inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz>"
            "</inertia></inertial></link>\n<joint name='j" +
            std::to_string(i) + "' type='revolute'><parent>base_link</parent><child>" + name +
            "</child><axis><xyz>0 0 -1</xyz><limit><lower>-1e16</lower><upper>1e16</upper>"
            "</limit></axis></joint>\n";
  }
  return text + "</model>\n</sdf>\n";
}

std::string with_sdf(std::string text) {
  return text.replace(text.find("urdf: q.urdf"), 12, "sdf: q.sdf");
}

TEST(OneDescription, AnSdfModelSaysTheSameAsAUrdf) {
  const test::TemporaryFolder folder;
  folder.write("q.urdf", quad_model(0.2, 0.3, 1.2, 0.02, 0.01));
  folder.write("q.sdf", quad_sdf(0.2, 0.3, 1.2, 0.02, 0.01));
  const std::string text = std::string(kQuadRest) +
                           "rotors: [{link: prop_1, spin: 1}, {link: prop_2, spin: 1}, {link: "
                           "prop_3, spin: -1}, {link: prop_4, spin: -1}]\n";
  const Vehicle urdf = Vehicle::load(folder.write("u.yaml", text));
  const Vehicle sdf = Vehicle::load(folder.write("s.yaml", with_sdf(text)));
  constexpr double kRounding = 1e-12;
  EXPECT_NEAR(sdf.mass_kg, urdf.mass_kg, kRounding);
  EXPECT_TRUE(sdf.inertia_kg_m2.isApprox(urdf.inertia_kg_m2, kRounding));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(sdf.rotors[i].position_B_m.isApprox(urdf.rotors[i].position_B_m, kRounding)) << i;
    EXPECT_TRUE(sdf.rotors[i].axis_B.isApprox(urdf.rotors[i].axis_B, kRounding)) << i;
  }
}

/// The version is two whole numbers: 1.10 comes after 1.9. Up to 1.4 axes are in the model's frame.
TEST(OneDescription, AnSdfModelsAxesAreInTheFrameOfItsVersion) {
  const test::TemporaryFolder folder;
  const auto lean = [&](const std::string& version) {
    std::string model = quad_sdf(0.2, 0.3, 1.2, 0.02, 0);
    folder.write("q.sdf", model.replace(model.find("1.9"), 3, version));
    const Vehicle vehicle = Vehicle::load(
        folder.write("q.yaml", with_sdf(kQuadRest) +
                                   "rotors: [{link: prop_1, spin: 1}, {link: prop_2, spin: 1}, "
                                   "{link: prop_3, spin: -1}, {link: prop_4, spin: -1}]\n"));
    return std::abs(vehicle.rotors[0].axis_B.y());
  };
  constexpr double kDigitsInTheFile = 1e-6;
  for (const char* version : {"1.5", "1.9", "1.10", "1.11", "1.12"}) {
    EXPECT_NEAR(lean(version), std::sin(0.3), kDigitsInTheFile) << version;
  }
  EXPECT_EQ(lean("1.4"), 0);
}

TEST(OneDescription, RotorsOfAModelThatCountsFromZeroAreFoundByTheirNumber) {
  const test::TemporaryFolder folder;
  std::string model = quad_sdf(0.2, 0, 1.2, 0.02, 0);
  for (std::size_t at = model.find("prop_"); at != std::string::npos; at = model.find("prop_")) {
    model.replace(at, 6, "rotor_" + std::to_string(model[at + 5] - '1'));
  }
  folder.write("q.sdf", model);
  const Vehicle vehicle = Vehicle::load(folder.write(
      "q.yaml", with_sdf(kQuadRest) + "rotors: [{spin: 1}, {spin: 1}, {spin: -1}, {spin: -1}]\n"));
  EXPECT_TRUE(vehicle.rotors[0].position_B_m.isApprox(Eigen::Vector3d(0.2, -0.2, 0.02)));
  EXPECT_TRUE(vehicle.rotors[3].position_B_m.isApprox(Eigen::Vector3d(-0.2, -0.2, 0.02)));
}

TEST(WrongSdf, IsRefusedWithItsPlace) {
  struct SdfCase {
    const char* name;
    const char* from;
    const char* to;
    const char* message;
  };
  const SdfCase rows[] = {
      {"Right", "q", "q", ""},
      {"OtherMass", "<mass>1.2", "<mass>1.3", "mass_kg: is 1.2, but "},
      {"OtherMassLine", "<mass>1.2", "<mass>1.3", "q.sdf:4 has 1.3"},
      {"OtherPlace", "<pose>0.200000 -0.2", "<pose>0.210000 -0.2",
       "q.sdf:6 has [0.2, -0.2, 0.02] (link 'prop_1'"},
      {"Include", "<link name='prop_1'>", "<include/><link name='prop_1'>",
       "q.sdf:5: <include> has no <uri>"},
      {"NoMass", "<mass>1.200000</mass>", "", "q.sdf:4: link 'base_link' has no <inertial>"},
      {"NoBody", "<iyy>0.02", "<iyy>0.9", "q.sdf:4: link 'base_link': no body has this <inertia>"},
      {"NoFrame", "<pose>0.200000 -0.2", "<pose relative_to='arm'>0.200000 -0.2",
       "q.sdf:5: the model has no link, joint or frame 'arm'"},
      {"Circle", "<pose>0.200000 -0.2", "<pose relative_to='prop_1'>0.200000 -0.2",
       "q.sdf:5: poses go round in a circle"},
      {"Words", "<pose>0.200000 -0.2", "<pose>left -0.2", "q.sdf:5: <pose> is not made of numbers"},
      {"Axis", "<xyz>0 0 -1", "<xyz>0 0 0", "q.sdf:6: <xyz> of an axis is zero"},
      {"Limited", "<lower>-1e16</lower><upper>1e16</upper>", "<lower>-1</lower><upper>1</upper>",
       ""},
      {"Broken", "</model>", "</modle>", "q.sdf:13: mismatched tag"}};
  for (const auto& [name, from, to, message] : rows) {
    SCOPED_TRACE(name);
    const test::TemporaryFolder folder;
    std::string model = quad_sdf(0.2, 0, 1.2, 0.02, 0.01);
    ASSERT_THAT(model, HasSubstr(from));
    folder.write("q.sdf", model.replace(model.find(from), std::string(from).size(), to));
    const auto file = folder.write("q.yaml", with_sdf(kQuadRest) + R"(mass_kg: 1.2
rotors:
  - {link: prop_1, position_B_m: [0.19, -0.2, 0.02], spin: 1}
  - {link: prop_2, spin: 1}
  - {link: prop_3, spin: -1}
  - {link: prop_4, spin: -1}
)");
    const std::string said = test::refusal([&] { Vehicle::load(file); });
    EXPECT_EQ(said.empty(), std::string(message).empty()) << said;
    EXPECT_THAT(said, HasSubstr(message));
  }
}

TEST(OneDescription, HasOneModelOnly) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("q.yaml", std::string(kQuadRest) + "sdf: q.sdf\n");
  EXPECT_THAT(test::refusal([&] { Vehicle::load(file); }),
              HasSubstr("sdf: is a second model beside 'urdf'"));
}

TEST(DifferentModel, IsRefusedWithBothValuesAndBothLines) {
  struct DifferentCase {
    const char* name;
    double arm, lean_rad, mass, inertia, cog_x;
    int rotors;
    std::vector<const char*> message;
  };
  const DifferentCase rows[] = {
      {"TheSame", 0.2, 0, 1.2, 0.02, 0, 4, {}},
      {"TwiceTheDistance",
       0.4,
       0,
       1.2,
       0.02,
       0,
       4,
       {"q.yaml:14: rotors[0].position_B_m: is [0.2, -0.2, 0.02]", "q.urdf:4", "[0.4, -0.4, 0.02]",
        "link 'prop_1'"}},
      {"OneLeans",
       0.2,
       0.5,
       1.2,
       0.02,
       0,
       4,
       {"q.yaml:14: rotors[0].axis_B: is [0, 0, 1]", "q.urdf:4", "-0.479426"}},
      {"SixRotors", 0.2, 0, 1.2, 0.02, 0, 6, {"rotors: lists 4 rotors", "q.urdf:8", "'prop_5'"}},
      {"Mass", 0.2, 0, 1.3, 0.02, 0, 4, {"q.yaml:11: mass_kg: is 1.2", "q.urdf:3 has 1.3"}},
      {"TenTimesTheInertia",
       0.2,
       0,
       1.2,
       0.2,
       0,
       4,
       {"q.yaml:12: inertia_kg_m2: is [0.02, 0.02, 0.03]", "q.urdf:3", "[0.2, 0.2, 0.3]"}},
      {"CentreOfGravity",
       0.2,
       0,
       1.2,
       0.02,
       0.05,
       4,
       {"rotors[0].position_B_m: is [0.2, -0.2, 0.02]", "[0.15, -0.2, 0.02]",
        "centre of gravity, which is at [0.05, 0, 0]"}}};
  for (const auto& c : rows) {
    SCOPED_TRACE(c.name);
    const test::TemporaryFolder folder;
    folder.write("q.urdf", quad_model(c.arm, c.lean_rad, c.mass, c.inertia, c.cog_x, c.rotors));
    const auto file = folder.write("q.yaml", std::string(kQuadRest) + R"(mass_kg: 1.2
inertia_kg_m2: [0.02, 0.02, 0.03]
rotors:
  - {position_B_m: [0.2, -0.2, 0.02], axis_B: [0, 0, 1], spin: 1}
  - {position_B_m: [-0.2, 0.2, 0.02], spin: 1}
  - {position_B_m: [0.2, 0.2, 0.02], spin: -1}
  - {position_B_m: [-0.2, -0.2, 0.02], spin: -1}
)");
    if (c.message.empty()) {
      EXPECT_NO_THROW(Vehicle::load(file));
      continue;
    }
    const std::string said = test::refusal([&] { Vehicle::load(file); });
    for (const char* part : c.message) {
      EXPECT_THAT(said, HasSubstr(part)) << part << " in " << said;
    }
  }
}

}  // namespace
}  // namespace cas::base
