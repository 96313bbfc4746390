// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/loop_design.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "base/angles.hpp"
#include "fcu/core/controller_description.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu {
namespace {

using testing::HasSubstr;
using testing::Not;

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
    derive_gains(vehicle, kUsualDelay_s, params);
    EXPECT_EQ(params.rate_roll.p, 20 * vehicle.inertia_kg_m2.x() / vehicle.scales.u2_max_nm)
        << name;
    EXPECT_EQ(params.roll_p, ControlParams{}.roll_p) << name;
    EXPECT_EQ(params.xy_p, ControlParams{}.xy_p) << name;
  }
}

/// |L| and its phase by sums of the parts' logarithms and angles, in real numbers.
double magnitude(const RateLoop& loop, double w) {
  const double x = w / (2 * M_PI * loop.gyro_cutoff_hz);
  const double y = w / (2 * M_PI * loop.dgyro_cutoff_hz);
  const double d = loop.d_per_p * w / std::sqrt(1 + std::pow(y, 4));
  const double d_angle = M_PI / 2 - std::atan2(std::sqrt(2.0) * y, 1 - y * y);
  const double real = 1 + d * std::cos(d_angle);
  const double imaginary = d * std::sin(d_angle) - loop.i_per_p / w;
  return loop.gain_rad_s / w * std::hypot(real, imaginary) / std::sqrt(1 + std::pow(x, 4)) *
         std::hypot(1, loop.lead_s * w) / std::hypot(1, loop.lag_s * w);
}

double phase_rad(const RateLoop& loop, double w) {
  const double x = w / (2 * M_PI * loop.gyro_cutoff_hz);
  const double y = w / (2 * M_PI * loop.dgyro_cutoff_hz);
  const double d = loop.d_per_p * w / std::sqrt(1 + std::pow(y, 4));
  const double d_angle = M_PI / 2 - std::atan2(std::sqrt(2.0) * y, 1 - y * y);
  return -M_PI / 2 +
         std::atan2(d * std::sin(d_angle) - loop.i_per_p / w, 1 + d * std::cos(d_angle)) -
         std::atan2(std::sqrt(2.0) * x, 1 - x * x) + std::atan(loop.lead_s * w) -
         std::atan(loop.lag_s * w) - loop.delay_s * w;
}

/// Where |L| = 1: it falls with the frequency.
double crossover_rad_s(const RateLoop& loop) {
  double low = 0.1;
  double high = 500;
  while (high - low > 1e-6) {
    const double middle = (low + high) / 2;
    (magnitude(loop, middle) > 1 ? low : high) = middle;
  }
  return low;
}

/// Where the phase is -180 degrees.
double half_turn_rad_s(const RateLoop& loop) {
  double low = crossover_rad_s(loop);
  double high = 1000;
  while (high - low > 1e-6) {
    const double middle = (low + high) / 2;
    (phase_rad(loop, middle) > -M_PI ? low : high) = middle;
  }
  return low;
}

base::Vehicle with_lag(double lag_s) {
  base::Vehicle vehicle = shipped("quad_x");
  for (base::Rotor& rotor : vehicle.rotors) {
    rotor.params.time_constant_up_s = rotor.params.time_constant_down_s = lag_s;
  }
  return vehicle;
}

struct SlowCase {
  const char* name;
  double lag_s;
  double delay_s;
};

class SlowLoop : public testing::TestWithParam<SlowCase> {};

/// What margins() says and the design has aimed at, by another calculation.
TEST_P(SlowLoop, IsLeftItsMarginsAndNoMore) {
  const auto& [name, lag_s, delay_s] = GetParam();
  const base::Vehicle vehicle = with_lag(lag_s);
  ControlParams params;
  derive_gains(vehicle, delay_s, params);
  EXPECT_LT(params.roll_p, ControlParams{}.roll_p);
  const std::array<RateLoop, 3> loops = rate_loops(vehicle, params, delay_s);
  for (const RateLoop& loop : loops) {
    const double crossover = crossover_rad_s(loop);
    const LoopMargins own = margins(loop);
    EXPECT_NEAR(own.crossover_rad_s, crossover, kGrid * crossover);
    EXPECT_NEAR(own.phase_rad, M_PI + phase_rad(loop, crossover), kGrid);
    EXPECT_GE(own.phase_rad, kPhaseMargin_rad - kGrid);
    EXPECT_NEAR(own.gain * magnitude(loop, half_turn_rad_s(loop)), 1, 4 * kGrid);
    EXPECT_GE(own.gain, kGainMargin);
  }
  const LoopMargins tilt = margins(loops[0]);
  EXPECT_LT(std::min(tilt.phase_rad / kPhaseMargin_rad, tilt.gain / kGainMargin), 1 + 3 * kGrid)
      << "no slower than need be";
}

/// The outer loops keep the ratios that the header states.
TEST_P(SlowLoop, TakesTheOuterLoopsWithIt) {
  const auto& [name, lag_s, delay_s] = GetParam();
  const base::Vehicle vehicle = with_lag(lag_s);
  ControlParams params;
  derive_gains(vehicle, delay_s, params);
  const auto loops = rate_loops(vehicle, params, delay_s);
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(params.roll_p, 0.35 * loops[0].gain_rad_s, kRounding);
  EXPECT_NEAR(params.pitch_p, 0.35 * loops[1].gain_rad_s, kRounding);
  EXPECT_NEAR(params.xy_velocity.p, 0.2 * loops[0].gain_rad_s, kRounding);
  EXPECT_NEAR(params.xy_p, 0.075 * loops[0].gain_rad_s, kRounding);
  EXPECT_NEAR(params.yaw_p, 0.4 * loops[2].gain_rad_s, kRounding);
}

INSTANTIATE_TEST_SUITE_P(All, SlowLoop,
                         testing::Values(SlowCase{"MotorsOf80ms", 0.08, kUsualDelay_s},
                                         SlowCase{"MotorsOf150ms", 0.15, kUsualDelay_s},
                                         SlowCase{"MotorsOf300ms", 0.3, kUsualDelay_s},
                                         SlowCase{"LineOf57600Baud", 0.02, 0.044},
                                         SlowCase{"Both", 0.15, 0.044}),
                         [](const auto& test) { return test.param.name; });

/// A step of the closed loop, integrated in time with the same parts: a little below the gain
/// margin it dies away, a little above it grows.
TEST(LoopMargins, AreTheEdgeOfStabilityOfTheStepResponse) {
  const auto late_swing = [](const RateLoop& loop, double factor) {
    constexpr double kStep_s = 1e-4;
    constexpr int kSteps = 60'000;
    std::vector<double> command(static_cast<std::size_t>(loop.delay_s / kStep_s), 0.0);
    const double gyro_w = 2 * M_PI * loop.gyro_cutoff_hz;
    double motors = 0, rate = 0, gyro = 0, gyro_dot = 0, integral = 0, swing = 0;
    for (int i = 0; i < kSteps; ++i) {
      gyro_dot += kStep_s * (gyro_w * gyro_w * (rate - gyro) - std::sqrt(2.0) * gyro_w * gyro_dot);
      gyro += kStep_s * gyro_dot;
      integral += kStep_s * loop.i_per_p * (1 - gyro);
      const std::size_t slot = static_cast<std::size_t>(i) % command.size();
      const double delayed = std::exchange(command[slot], factor * (1 - gyro + integral));
      motors += kStep_s * (delayed - motors) / loop.lag_s;
      rate += kStep_s * loop.gain_rad_s * motors;
      if (i > kSteps * 2 / 3) swing = std::max(swing, std::abs(gyro - 1));
    }
    return swing;
  };
  const RateLoop loop{
      .gain_rad_s = 9, .i_per_p = 0.7, .lag_s = 0.08, .delay_s = 0.01, .gyro_cutoff_hz = 60};
  const double gain = margins(loop).gain;
  EXPECT_LT(late_swing(loop, 0.95 * gain), 0.5);
  EXPECT_GT(late_swing(loop, 1.05 * gain), 2);
}

/// J dw/dt beside 2 k_m w dw of each rotor: J / (2 k_m w) at the speed of hover.
TEST(YawLead, IsThatOfTheRotorsReaction) {
  const base::Vehicle quad = shipped("quad_x");
  const base::RotorParams& rotor = quad.rotors[0].params;
  const double hover_rad_s = std::sqrt(quad.mass_kg * 9.80665 / 4 / rotor.thrust_coefficient);
  const double lead_s = rotor.inertia_kg_m2 / (2 * rotor.torque_coefficient * hover_rad_s);
  EXPECT_NEAR(yaw_lead_s(quad), lead_s, 1e-6 * lead_s);
}

FcuConfig config_of(const std::string& vehicle, double baud, double control_rate_hz) {
  FcuConfig config;
  config.vehicle = shipped(vehicle);
  config.sensors = config.vehicle.sensors;
  config.line = LineConfig::from_preset("baud_921600");
  config.line.baud = baud;
  config.control_rate_hz = control_rate_hz;
  return config;
}

TEST(DescribedController, WarnsOfALoopThatItsLineMakesUnstable) {
  FcuConfig config = config_of("iris_paper", 921600, 400);
  EXPECT_NEAR(loop_delay_s(config), kUsualDelay_s, 2e-4);
  EXPECT_THAT(describe_controller(config), Not(HasSubstr("warning")));
  config.line.extra_delay = std::chrono::milliseconds(40);
  EXPECT_THAT(describe_controller(config),
              HasSubstr("warning: roll: less than 30 degrees or 6 dB"));
}

TEST(DescribedController, WarnsOfGainsInItsFileThatAreTooHigh) {
  FcuConfig config = config_of("iris_paper", 921600, 400);
  config.params = {{"MC_ROLLRATE_K", 5}};
  EXPECT_THAT(describe_controller(config), HasSubstr("warning: roll"));
}

/// The controller knows its baud rate and its control rate, but not the delays of a line's model.
TEST(DesignDelay, IsThatOfTheBaudRateAndTheControlPeriod) {
  FcuConfig config = config_of("iris_paper", 57600, 50);
  EXPECT_NEAR(design_delay_s(config), 1300 / 57600.0 + 1 / 50.0 + 0.0011, 1e-9);
  EXPECT_THAT(describe_controller(config), Not(HasSubstr("warning")));
  config.line.extra_delay = std::chrono::milliseconds(40);
  EXPECT_NEAR(design_delay_s(config), 1300 / 57600.0 + 1 / 50.0 + 0.0011, 1e-9);
  EXPECT_EQ(design_delay_s(config_of("iris_paper", 0, 400)), kUsualDelay_s);
}

}  // namespace
}  // namespace cas::fcu
