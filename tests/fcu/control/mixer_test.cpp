// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/mixer.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "base/error.hpp"
#include "base/random.hpp"
#include "tests/fcu/support/frames.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector4d;

constexpr double kHover_n = 15.2;
constexpr double kMixerTolerance = 1e-9;  // of numbers of order one to ten

base::Vehicle load(const char* name) {
  return base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/" + name + ".yaml");
}

TEST(Mixer, PassesWhatTheRotorsCanDo) {
  const Mixer mixer(load("iris_paper"));
  const Vector4d demand(kHover_n, 0.3, -0.4, 0.05);
  const MixerResult result = mixer.mix(demand);
  EXPECT_TRUE(result.u.isApprox(demand, kMixerTolerance));
  for (const Saturation& s : result.torque) EXPECT_FALSE(s.up || s.down);
}

TEST(Mixer, GivesUpYawBeforeThrust) {
  const Mixer mixer(load("iris_paper"));
  const MixerResult result = mixer.mix({kHover_n, 0, 0, 5});
  EXPECT_NEAR(result.u[0], kHover_n, kMixerTolerance);
  EXPECT_NEAR(result.u[1], 0, kMixerTolerance);
  EXPECT_LT(result.u[3], 5);
  EXPECT_GT(result.u[3], 0.1);
  EXPECT_TRUE(result.torque[2].up);
}

TEST(Mixer, GivesUpThrustBeforeRollAndPitch) {
  const Mixer mixer(load("iris_paper"));
  const MixerResult result = mixer.mix({28.0, 1.0, 0.5, 0.2});
  EXPECT_NEAR(result.u[1], 1.0, kMixerTolerance);
  EXPECT_NEAR(result.u[2], 0.5, kMixerTolerance);
  EXPECT_LT(result.u[0], 28.0);
  EXPECT_TRUE(result.thrust.up);
}

TEST(Mixer, ScalesRollAndPitchTogetherWhenEvenThrustDoesNotHelp) {
  const Mixer mixer(load("iris_paper"));
  const MixerResult result = mixer.mix({kHover_n, 6, 3, 0});
  EXPECT_LT(result.u[1], 6);
  EXPECT_NEAR(result.u[1] / result.u[2], 2, 1e-6);
  EXPECT_TRUE(result.torque[0].up);
}

TEST(Mixer, RaisesThrustForRollInTheAirButNotOnTheGround) {
  const Mixer mixer(load("iris_paper"));
  const Vector4d demand(1.0, 1.0, 0, 0);
  EXPECT_GT(mixer.mix(demand, true).u[0], 2);
  EXPECT_LE(mixer.mix(demand, false).u[0], 1.0 + kMixerTolerance);
  EXPECT_NEAR(mixer.mix(demand, true).u[1], 1.0, kMixerTolerance);
}

TEST(MixerOnAnyVehicle, NeverAsksForMoreThanTheRotorsHave) {
  for (const char* text : {"iris_paper", "iris_px4"}) {
    SCOPED_TRACE(text);
    const base::Vehicle vehicle = load(text);
    const Mixer mixer(vehicle);
    const double low = std::pow(vehicle.rotors[0].params.omega_idle_rad_s, 2);
    const double high = std::pow(vehicle.rotors[0].params.omega_max_rad_s, 2);
    base::NormalRandom random(7);
    for (int i = 0; i < 5000; ++i) {
      const Vector4d demand(15 + 15 * random(), 3 * random(), 3 * random(), random());
      for (const bool may_lift : {true, false}) {
        const MixerResult result = mixer.mix(demand, may_lift);
        EXPECT_GE(result.omega_sq.minCoeff(), low - 1e-6);
        EXPECT_LE(result.omega_sq.maxCoeff(), high + 1e-6);
        const Vector4d u = vehicle.mixing_matrix() * result.omega_sq;
        EXPECT_TRUE(u.isApprox(result.u, 1e-9));
        // Never more torque than asked for, never in the other direction.
        for (int axis = 1; axis < 4; ++axis) {
          EXPECT_LE(std::abs(result.u[axis]), std::abs(demand[axis]) + 1e-6);
          EXPECT_GE(result.u[axis] * demand[axis], -1e-6);
        }
      }
    }
  }
}

TEST(Mixer, MapsIdleAndFullSpeedToZeroAndOne) {
  const base::Vehicle vehicle = load("iris_paper");
  const Mixer mixer(vehicle);
  const double full = std::pow(vehicle.rotors[0].params.omega_max_rad_s, 2);
  MixerResult fastest;
  fastest.omega_sq = Vector4d::Constant(full);
  for (std::size_t i = 0; i < base::kMaxOutputs; ++i) {
    EXPECT_EQ(mixer.output_kind(i), i < 4 ? OutputKind::kMotor : OutputKind::kNothing);
    EXPECT_NEAR(mixer.outputs(mixer.idle())[i], 0, 1e-9);
    EXPECT_NEAR(mixer.outputs(fastest)[i], i < 4 ? 1 : 0, 1e-9);
  }
}

TEST(Mixer, PutsRotorsAndServosOnTheirOutputs) {
  base::Vehicle vehicle = test::tri();
  vehicle.rotors[0].output = 2;
  vehicle.rotors[1].output = 0;
  vehicle.rotors[2].output = 5;
  vehicle.rotors[2].tilt->output = 15;
  const Mixer mixer(vehicle);
  EXPECT_EQ(mixer.output_kind(15), OutputKind::kServo);
  EXPECT_EQ(mixer.output_kind(1), OutputKind::kNothing);
  MixerResult result = mixer.idle();
  result.omega_sq[0] = std::pow(vehicle.rotors[0].params.omega_max_rad_s, 2);
  result.tilt_rad[2] = -0.3;
  const auto outputs = mixer.outputs(result);
  EXPECT_NEAR(outputs[2], 1, 1e-12);
  EXPECT_NEAR(outputs[0], 0, 1e-12);
  EXPECT_NEAR(outputs[15], -0.5, 1e-12);
  EXPECT_EQ(outputs[1], 0);
}

TEST(Mixer, AsksAServoForItsTiltAboutItsMiddle) {
  base::Vehicle vehicle = test::tri();
  vehicle.rotors[2].tilt->middle_rad = 0.3;
  const Mixer mixer(vehicle);
  MixerResult result = mixer.idle();
  for (const double tilt : {-0.6, -0.2, 0.0, 0.3, 0.5, 0.6}) {
    result.tilt_rad[2] = tilt;
    EXPECT_NEAR(vehicle.rotors[2].tilt->angle_rad(mixer.outputs(result)[3]), tilt, 1e-12);
  }
}

TEST(Mixer, RefusesRotorsThatCannotRoll) {
  std::vector<base::Rotor> line{test::rotor(0.3, 0, 1), test::rotor(0.3, 180, -1)};
  EXPECT_THROW(Mixer(test::frame("line", line, 1, {0.01, 0.01, 0.02})), base::ConfigError);
}

}  // namespace
}  // namespace cas::fcu
