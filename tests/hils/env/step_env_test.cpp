// SPDX-License-Identifier: BSD-3-Clause
#include "hils/env/step_env.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/error.hpp"
#include "tests/support/paths.hpp"

namespace cas::hils {
namespace {

constexpr std::size_t kNorth = 0;
constexpr std::size_t kVelocityNorth = 3;

StepEnvOptions high_up(Stand stand, View view) {
  return {.setup = "{vehicle: " + test::source_dir() +
                   "/config/vehicles/iris_paper.yaml, sensors: table1, pose: {z_m: 50}}",
          .vary = {},
          .stand = stand,
          .view = view};
}

std::vector<double> fly(StepEnv& env, const std::vector<double>& action, int steps,
                        std::uint64_t seed) {
  env.reset(seed);
  for (int i = 0; i < steps; ++i) env.step(action);
  std::vector<double> observation(env.observation_names().size());
  env.observe(observation);
  return observation;
}

TEST(StepEnv, FliesAtTheVelocityThatIsAskedFor) {
  StepEnv env(high_up(Stand::kVelocity, View::kTruth));
  const auto seen = fly(env, {1, 0, 0, 0}, 2000, 1);
  EXPECT_NEAR(seen[kVelocityNorth], 1, 0.1);
  EXPECT_GT(seen[kNorth], 2);
  EXPECT_NEAR(env.time_s(), 4, 1e-9);
}

TEST(StepEnv, RepeatsAnEpisodeByItsSeed) {
  StepEnv env(high_up(Stand::kRates, View::kSensors));
  const auto first = fly(env, {0.1, 0, 0, 0.6}, 300, 5);
  const auto other = fly(env, {0.1, 0, 0, 0.6}, 300, 6);
  EXPECT_EQ(fly(env, {0.1, 0, 0, 0.6}, 300, 5), first);
  EXPECT_NE(other, first);
}

TEST(StepEnv, DrawsWhatAStudyWouldDraw) {
  auto options = high_up(Stand::kMotors, View::kTruth);
  options.vary =
      "[{name: x, key: pose.x_m, uniform: [2, 3]}, {key: pose.yaw_deg, values: [0, 90]}]";
  StepEnv env(options);
  std::vector<double> east;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    east.push_back(fly(env, {0, 0, 0, 0}, 1, seed)[1]);
    EXPECT_NEAR(east.back(), std::stod(env.drawn().at(0).second), 1e-3);
    EXPECT_EQ(env.drawn().at(1).second, seed % 2 == 0 ? "0" : "90");
  }
  EXPECT_GE(std::ranges::min(east), 2);
  EXPECT_LE(std::ranges::max(east), 3);
  std::ranges::sort(east);
  EXPECT_EQ(std::ranges::adjacent_find(east), east.end());
}

TEST(StepEnv, RefusesAnActionOfAnotherSizeAndAStepBeforeTheFirstReset) {
  StepEnv env(high_up(Stand::kMotors, View::kTruth));
  const std::vector<double> three(3);
  const std::vector<double> four(4);
  EXPECT_THROW(env.step(four), base::ConfigError);
  env.reset(1);
  EXPECT_THROW(env.step(three), base::ConfigError);
  EXPECT_NO_THROW(env.step(four));
}

}  // namespace
}  // namespace cas::hils
