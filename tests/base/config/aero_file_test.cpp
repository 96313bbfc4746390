// SPDX-License-Identifier: BSD-3-Clause
// Block `aero` of a vehicle file.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/config/vehicle.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

/// A vehicle file without its ending: a shipped one, or the plane of the tests.
std::string plane_file(const std::string& plane) {
  const char* folder = plane == "panel_plane" ? "/tests/plugins/data/" : "/config/vehicles/";
  return test::source_dir() + folder + plane;
}

/// A plane of the tests with one change of its text, from a folder of its own.
Vehicle load_changed(const std::string& plane, const std::string& from, const std::string& to) {
  const test::TemporaryFolder folder;
  std::string text = test::TemporaryFolder::read(plane_file(plane) + ".yaml");
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  folder.write(plane + ".urdf", test::TemporaryFolder::read(plane_file(plane) + ".urdf"));
  return Vehicle::load(folder.write("plane.yaml", text));
}

TEST(AeroFile, ReadsSurfacesDerivativesAndPanels) {
  const Vehicle aerosonde = Vehicle::load(plane_file("aerosonde") + ".yaml");
  ASSERT_TRUE(aerosonde.aero && aerosonde.aero->derivatives);
  EXPECT_EQ(aerosonde.aero->cruise_m_s, 25);
  ASSERT_EQ(aerosonde.aero->surfaces.size(), 3U);
  EXPECT_EQ(aerosonde.aero->surfaces[1].output, 1);
  const DerivativeParams& body = *aerosonde.aero->derivatives;
  EXPECT_NEAR(body.stall_rad, 0.47, 1e-9);
  EXPECT_EQ(body.lift.alpha, 5.61);
  EXPECT_EQ(body.yaw.surfaces, (std::vector{-0.011, 0.0, -0.069}));

  const Vehicle plane = Vehicle::load(plane_file("panel_plane") + ".yaml");
  ASSERT_EQ(plane.aero->panels.size(), 6U);
  const PanelParams& elevator = plane.aero->panels[4];
  EXPECT_EQ(elevator.area_m2, 0.01);  // its own goes before the common one
  EXPECT_EQ(elevator.surface, 4);
  EXPECT_EQ(elevator.lift_slope_per_rad, 4.7527987);
  EXPECT_EQ(plane.aero->panels[5].normal_B, Eigen::Vector3d::UnitY());
  const ControlSurface& flap = plane.aero->surfaces[1];  // turned round
  EXPECT_NEAR(flap.angle_rad(1), -M_PI / 6, 1e-12);
  EXPECT_NEAR(flap.angle_rad(-0.5), M_PI / 12, 1e-12);
}

TEST(AeroFile, ADerivativePerDegreeIsTheSameAsOnePerRadian) {
  const Vehicle vehicle =
      load_changed("aerosonde", "per_rad: {elevator: -0.99}", "per_deg: {elevator: -0.0172787596}");
  EXPECT_NEAR(vehicle.aero->derivatives->pitch.surfaces[1], -0.99, 1e-8);
}

TEST(WrongAeroBlock, IsRefusedWithItsPlace) {
  struct WrongAero {
    const char* name;
    const char* plane;
    const char* from;
    const char* to;
    const char* place;  // of FILE:LINE: path: sentence
  };
  const WrongAero rows[] = {
      {"NegativeChord", "aerosonde", "chord_m: 0.18994", "chord_m: -0.18994",
       ": aero.derivatives.chord_m: must be above zero"},
      {"AnOutputTwice", "aerosonde", "name: rudder, output: 3", "name: rudder, output: 2",
       ": aero.surfaces[2].output: output 2 drives something else already"},
      {"ARotorsOutput", "aerosonde", "name: rudder, output: 3", "name: rudder, output: 4",
       ": aero.surfaces[2].output: output 4 drives something else already"},
      {"ANameTwice", "aerosonde", "name: rudder,", "name: elevator,",
       "aero.surfaces[2].name: is the name of another surface, too"},
      {"SurfaceThatIsNotThere", "panel_plane", "surface: elevator,", "surface: elevatr,",
       "aero.panels[4].surface: 'elevatr' is none of the surfaces of 'aero.surfaces'; did "
       "you mean 'elevator'?"},
      {"SurfaceOfARowThatIsNotThere", "aerosonde", "per_rad: {elevator: 0.13}",
       "per_rad: {flap: 0.13}",
       "aero.derivatives.lift.per_rad.flap: 'flap' is none of the surfaces"},
      {"SurfaceWithoutEffect", "panel_plane", ", surface: right_flap", "",
       "aero.surfaces[5].name: has no effect: no row of 'derivatives' and no panel names "
       "'right_flap'"},
      {"DerivativeWithoutUnit", "aerosonde", "per_rad: {elevator: 0.13}", "elevator: 0.13",
       "elevator"},
      {"DownwashWithoutAWing", "panel_plane", "area_m2: 0.01,", "area_m2: 0.01, downwash_share: 1,",
       "aero: key 'wing_span_m' is missing"},
      {"WashOfARotorThatIsNotThere", "panel_plane", "area_m2: 0.01,",
       "area_m2: 0.01, in_wash_of: 2,",
       "aero.panels[4].in_wash_of: must be the number of a rotor, 1 to 1"},
      {"WashOfARotorThatTilts", "tiltrotor", "area_m2: 0.01,", "area_m2: 0.01, in_wash_of: 1,",
       "aero.panels[2].in_wash_of: names a rotor with a tilt servo"},
      {"PolarWithoutAChord", "panel_plane", "area_m2: 0.01,", "area_m2: 0.01, polar: tail.csv,",
       "'aero.panels[4].chord_m', 'aero.panels[4].plate_normal_force'"},
      {"MissingKeys", "aerosonde",
       "    efficiency: 0.9\n    stall_deg: 26.929016371        # 0.47 rad\n", "",
       "keys are missing: 'aero.derivatives.efficiency', 'aero.derivatives.stall_deg'"},
      {"NoDamping", "aerosonde", "  cruise_m_s: 25\n", "", "'cruise_m_s'"},
      {"BothLimitsOfOneSign", "aerosonde", "name: aileron, output: 1, min_deg: -30",
       "name: aileron, output: 1, min_deg: 30",
       "aero.surfaces[0].max_deg: must have the other sign than min_deg"},
      {"AnotherForm", "aerosonde", "form: beard", "form: etkin",
       "aero.derivatives.form: must be beard or avl"},
      {"LiftAcrossTheAir", "panel_plane", "after_stall_lift_slope_per_rad: -3.85",
       "after_stall_lift_slope_per_rad: -1",
       "after_stall_lift_slope_per_rad: leaves lift at 90 deg"},
      {"AreaTwice", "panel_plane", "area_m2: 0.6", "area_m2: 0.6\n    span_m: 1",
       "span_m: is given beside area_m2; leave one out"},
      {"MomentWithoutChord", "panel_plane", "area_m2: 0.6", "area_m2: 0.6\n    moment_zero: 0.1",
       "chord_m"},
      {"NormalAlongTheChord", "panel_plane", "normal_B: [0, 1, 0]", "normal_B: [1, 0, 0]",
       "normal_B: points along forward_B"},
      {"NothingInTheAir", "panel_plane",
       "\n  panels:", "\n  other:", "needs 'derivatives' or 'panels'"}};
  for (const auto& [name, plane, from, to, place] : rows) {
    SCOPED_TRACE(name);
    const std::string message = test::refusal([&] { load_changed(plane, from, to); });
    EXPECT_NE(message.find("plane.yaml:"), std::string::npos) << message;
    EXPECT_NE(message.find(place), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace cas::base
