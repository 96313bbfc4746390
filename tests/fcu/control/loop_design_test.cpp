// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/loop_design.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/angles.hpp"
#include "fcu/core/controller_description.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu {
namespace {

constexpr double kGrid =
    0.006;  ///< relative: the frequencies that margins() looks at are 0.5 % apart

base::Vehicle shipped(const std::string& name) {
  return base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/" + name + ".yaml");
}

/// k exp(-s T) / s: |L| is 1 at k, the phase there is -90 degrees less k T, and -180 degrees at
/// pi / (2 T).
TEST(LoopMargins, OfAnIntegratorWithADelayAreThoseOfTheClosedForm) {
  constexpr double kGain = 20;
  constexpr double kDelay_s = 0.01;
  const LoopMargins own = margins({.gain_rad_s = kGain, .delay_s = kDelay_s});
  EXPECT_NEAR(own.crossover_rad_s, kGain, kGrid * kGain);
  EXPECT_NEAR(own.phase_rad, M_PI / 2 - kGain * kDelay_s, kGrid);
  EXPECT_NEAR(own.gain, M_PI / (2 * kGain * kDelay_s), 2 * kGrid * own.gain);
}

/// k / (s (lag s + 1)): the crossover solves w^2 (1 + lag^2 w^2) = k^2; the phase never reaches
/// -180 degrees.
TEST(LoopMargins, OfAnIntegratorWithALagAreThoseOfTheClosedForm) {
  constexpr double kGain = 20;
  constexpr double kLag_s = 0.1;
  const double w = std::sqrt((std::sqrt(1 + 4 * std::pow(kGain * kLag_s, 2)) - 1) / 2) / kLag_s;
  const LoopMargins own = margins({.gain_rad_s = kGain, .lag_s = kLag_s});
  EXPECT_NEAR(own.crossover_rad_s, w, kGrid * w);
  EXPECT_NEAR(own.phase_rad, M_PI / 2 - std::atan(kLag_s * w), kGrid);
  EXPECT_TRUE(std::isinf(own.gain));
}

TEST(DerivedGains, OfQuickMotorsAreTheUsualOnes) {
  for (const char* name : {"iris_paper", "iris_px4", "quad_x", "hexa_x", "octo_x", "tri", "y6"}) {
    const base::Vehicle vehicle = shipped(name);
    ControlParams params;
    derive_gains(vehicle, params);
    EXPECT_EQ(params.rate_roll.p, 20 * vehicle.inertia_kg_m2.x() / vehicle.scales.u2_max_nm)
        << name;
    EXPECT_EQ(params.roll_p, ControlParams{}.roll_p) << name;
    EXPECT_EQ(params.xy_p, ControlParams{}.xy_p) << name;
  }
}

TEST(DerivedGains, OfSlowMotorsLeaveThePhaseMargin) {
  for (const double lag_s : {0.08, 0.15, 0.3}) {
    base::Vehicle vehicle = shipped("quad_x");
    for (base::Rotor& rotor : vehicle.rotors) {
      rotor.params.time_constant_up_s = rotor.params.time_constant_down_s = lag_s;
    }
    ControlParams params;
    derive_gains(vehicle, params);
    EXPECT_LT(params.roll_p, ControlParams{}.roll_p) << lag_s;
    for (const RateLoop& loop : rate_loops(vehicle, params, kUsualDelay_s)) {
      EXPECT_GE(margins(loop).phase_rad, kPhaseMargin_rad - kGrid) << lag_s;
      EXPECT_GT(margins(loop).gain, 2) << lag_s;
    }
  }
}

TEST(DescribedController, WarnsOfALoopThatItsLineMakesUnstable) {
  FcuConfig config;
  config.vehicle = shipped("iris_paper");
  config.sensors = config.vehicle.sensors;
  config.line = LineConfig::from_preset("baud_921600");
  EXPECT_NEAR(loop_delay_s(config), kUsualDelay_s, 2e-4);
  EXPECT_EQ(describe_controller(config).find("warning"), std::string::npos)
      << describe_controller(config);
  config.line.extra_delay = std::chrono::milliseconds(40);
  EXPECT_NE(describe_controller(config).find("warning: roll: less than 30 degrees"),
            std::string::npos)
      << describe_controller(config);
}

}  // namespace
}  // namespace cas::fcu
