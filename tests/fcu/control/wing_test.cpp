// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/control/surface_allocation.hpp"
#include "fcu/control/wing_airframe.hpp"
#include "fcu/control/wing_attitude.hpp"
#include "fcu/control/wing_controller.hpp"
#include "fcu/core/airspeed_meter.hpp"
#include "fcu/params/param_table.hpp"
#include "fcu/params/params.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector3d;

base::Vehicle shipped(const std::string& name) {
  return base::Vehicle::load(test::source_dir() + "/config/vehicles/" + name + ".yaml");
}

TEST(Airframe, IsToldByWingAndRotors) {
  EXPECT_EQ(airframe_kind(shipped("iris_paper")), AirframeKind::kMulticopter);
  EXPECT_EQ(airframe_kind(shipped("hexa_tilt")), AirframeKind::kMulticopter);
  EXPECT_EQ(airframe_kind(shipped("plane")), AirframeKind::kPlane);
  EXPECT_EQ(airframe_kind(shipped("standard_vtol")), AirframeKind::kVtol);
}

TEST(Airframe, LiftsAVtolByItsFourRotorsAlone) {
  const base::Vehicle part = lifting_part(shipped("standard_vtol"));
  EXPECT_EQ(part.rotor_count(), 4);
  EXPECT_NEAR(part.scales.u1_max_n, 180, 1e-9);
  EXPECT_EQ(lifting_part(shipped("plane")).rotor_count(), 0);
}

/// Coefficients of plane.yaml by hand: each wing panel 0.6 m^2 at 4.7528 per rad.
TEST(WingFigures, AreThoseOfThePanels) {
  const WingFigures figures = WingFigures::of(*shipped("plane").aero);
  EXPECT_NEAR(figures.lift_slope_m2, (4 * 0.6 + 0.01) * 4.752798721, 1e-6);
  EXPECT_NEAR(figures.damping_m4.x(),
              4.752798721 * (0.6 * 2 * (0.45 * 0.45 + 0.15 * 0.15) + 0.02 * 0.05 * 0.05), 1e-6);
  EXPECT_NEAR(figures.stiffness_m3, 4.752798721 * (2.4 * 0.05 + 0.01 * 0.5), 1e-6);
}

TEST(WingFigures, CarryTheWeightAtTheTrimsAngleOfAttack) {
  const base::Vehicle plane = shipped("plane");
  const double weight_n = plane.mass_kg * 9.80665;
  // `hilsim --describe`: -2.888 deg, which has the propeller's and the drag's part, too.
  EXPECT_NEAR(WingFigures::of(*plane.aero).angle_of_attack_rad(weight_n, 0.5 * 1.225 * 225),
              -2.888 * M_PI / 180, 0.006);
}

// To the right the left wing lifts: its aileron's lift per rad is below 0, so it goes to -1.
TEST(Surfaces, MoveAsTheVehicleFileSays) {
  struct OutputCase {
    const char* name;
    const char* vehicle;
    Vector3d demand;                           // about Dx, Dy, Dz
    std::vector<std::pair<int, int>> outputs;  // of the file (1..), sign
  };
  const OutputCase rows[] = {{"PlaneRolls", "plane", {0.5, 0, 0}, {{6, -1}, {7, 1}}},
                             {"PlanePitches", "plane", {0, 0.5, 0}, {{8, 1}}},
                             {"PlaneYaws", "plane", {0, 0, 0.5}, {{3, 1}}},
                             {"VtolRolls", "standard_vtol", {0.5, 0, 0}, {{6, -1}, {7, 1}}},
                             {"VtolPitches", "standard_vtol", {0, 0.5, 0}, {{8, 1}}},
                             {"VtolHasNoRudder", "standard_vtol", {0, 0, 0.5}, {}}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    const base::Vehicle vehicle = shipped(test.vehicle);
    const SurfaceAllocation surfaces(*vehicle.aero, WingFigures::of(*vehicle.aero));
    std::array<double, base::kMaxOutputs> outputs{};
    surfaces.put(test.demand, outputs);
    for (int i = 1; i <= base::kMaxOutputs; ++i) {
      int sign = 0;
      for (const auto& [output, wanted] : test.outputs) sign = output == i ? wanted : sign;
      const double value = outputs[static_cast<std::size_t>(i - 1)];
      if (sign == 0) {
        EXPECT_LT(std::abs(value), 0.12) << "output " << i;
      } else {
        EXPECT_GT(sign * value, 0.3) << "output " << i;
      }
    }
  }
}

TEST(Turn, GoesRoundByGravityTimesTangentOverSpeed) {
  constexpr double kRoll_rad = 0.5;
  constexpr double kPitch_rad = 0.1;
  const Vector3d w_D = turn_rates_rad_s(kRoll_rad, kPitch_rad, 15);
  // About the vertical alone, by as much.
  const Vector3d w_N = base::quaternion_rpy(kRoll_rad, kPitch_rad, 1) * w_D;
  EXPECT_NEAR(w_N.x(), 0, 1e-12);
  EXPECT_NEAR(w_N.y(), 0, 1e-12);
  EXPECT_NEAR(w_N.z(), 9.80665 * std::tan(kRoll_rad) / 15, 1e-12);
}

TEST(WingAttitude, DeflectsByTheInverseOfTheDynamicPressure) {
  WingParams params{.roll_rate = {.p = 0.1}};
  params.airspeed_trim_m_s = 15;
  const auto roll_at = [&params](double airspeed_m_s) {
    WingAttitude attitude;
    attitude.set_params(params);
    WingAttitude::Input in;
    in.roll_rad = 0.2;
    in.airspeed = {airspeed_m_s, airspeed_m_s, true};
    return attitude.update(in, 0.004).x();
  };
  EXPECT_NEAR(roll_at(15), 0.1 * 0.2 / 0.4, 1e-12);
  EXPECT_NEAR(roll_at(10), 2.25 * roll_at(15), 1e-12);
}

TEST(Airspeed, IsThatOfThePitotTubeOrOverGround) {
  using std::chrono::milliseconds;
  const base::RunTime start{};
  AirspeedMeter meter;
  EXPECT_FALSE(meter.read(11, true, start).measured);
  EXPECT_DOUBLE_EQ(meter.read(11, true, start).equivalent_m_s, 11);
  meter.on_sample(0.5 * 1.225 * 15 * 15, start);
  EXPECT_TRUE(meter.read(11, true, start).measured);
  EXPECT_NEAR(meter.read(11, true, start).equivalent_m_s, 15, 1e-9);
  EXPECT_FALSE(meter.read(11, false, start).measured);
  EXPECT_FALSE(meter.read(11, true, start + milliseconds(1100)).measured);
}

TEST(Airspeed, IsFasterInThinAir) {
  AirspeedMeter meter;
  meter.set_air(101325, 15);
  EXPECT_NEAR(meter.read(20, false, {}).equivalent_m_s, 20, 1e-3);
  meter.set_air(79495, 2);  // some 2000 m high: 1.007 kg/m^3
  EXPECT_NEAR(meter.read(20, false, {}).equivalent_m_s, 20 * std::sqrt(1.0065 / 1.225), 0.01);
}

TEST(WingParams, AreOfVehiclesWithAWingAlone) {
  const ParamStore quad(shipped("iris_paper"));
  const ParamStore plane(shipped("plane"));
  const ParamStore vtol(shipped("standard_vtol"));
  EXPECT_FALSE(quad.index_of("FW_AIRSPD_TRIM"));
  EXPECT_DOUBLE_EQ(plane.get("FW_AIRSPD_TRIM"), 15);
  EXPECT_FALSE(plane.index_of("VT_ARSP_TRANS"));
  EXPECT_NEAR(vtol.get("VT_ARSP_TRANS"), 12, 1e-6);
  EXPECT_EQ(plane.get_int("MAV_TYPE"), 1);
  EXPECT_EQ(vtol.get_int("MAV_TYPE"), 22);
}

}  // namespace
}  // namespace cas::fcu
