// SPDX-License-Identifier: BSD-3-Clause
#include "hils/env/step_env.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

constexpr std::size_t kNorth = 0;
constexpr std::size_t kVelocityNorth = 3;

StepEnvOptions high_up(ActionLevel action_level, View view) {
  return {.setup = "{vehicle: " + test::source_dir() +
                   "/config/vehicles/iris_paper.yaml, sensors: table1, pose: {z_m: 50}}",
          .vary = {},
          .action_level = action_level,
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
  StepEnv env(high_up(ActionLevel::kVelocity, View::kTruth));
  const auto seen = fly(env, {1, 0, 0, 0}, 2000, 1);
  EXPECT_NEAR(seen[kVelocityNorth], 1, 0.1);
  EXPECT_GT(seen[kNorth], 2);
  EXPECT_NEAR(env.time_s(), 4, 1e-9);
}

TEST(StepEnv, RepeatsAnEpisodeByItsSeed) {
  StepEnv env(high_up(ActionLevel::kRates, View::kSensors));
  const auto first = fly(env, {0.1, 0, 0, 0.6}, 300, 5);
  const auto other = fly(env, {0.1, 0, 0, 0.6}, 300, 6);
  EXPECT_EQ(fly(env, {0.1, 0, 0, 0.6}, 300, 5), first);
  EXPECT_NE(other, first);
}

TEST(StepEnv, DrawsWhatAStudyWouldDraw) {
  auto options = high_up(ActionLevel::kMotors, View::kTruth);
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

TEST(StepEnv, PushesATiltedHexacopterSidewaysAsTheEmulatedControllerDoes) {
  auto options = high_up(ActionLevel::kVelocity, View::kTruth);
  options.setup = "{vehicle: " + test::source_dir() +
                  "/config/vehicles/hexa_tilt.yaml, sensors: table1, pose: {z_m: 50}}";
  const auto most_tilt = [](const StepEnvOptions& with) {
    constexpr std::size_t kQuaternionX = 7;
    StepEnv env(with);
    env.reset(1);
    std::vector<double> seen(env.observation_names().size());
    double most = 0;
    for (int i = 0; i < 2500; ++i) {
      env.step(std::vector<double>{i < 1000 ? 0.0 : 0.3, 0, 0, 0});
      env.observe(seen);
      most = std::max(most, std::hypot(seen[kQuaternionX], seen[kQuaternionX + 1]));
    }
    EXPECT_NEAR(seen[kVelocityNorth], 0.3, 0.05);
    for (std::size_t rotor = seen.size() - 6; rotor < seen.size(); ++rotor) {
      EXPECT_GT(seen[rotor], 300) << "no rotor was taken for lost while they began to turn";
    }
    return most;
  };
  const double level = most_tilt(options);
  options.setup.insert(options.setup.size() - 1, ", params: {CAS_SIDE_SHARE: 0}");
  EXPECT_LT(level, 0.3 * most_tilt(options));
}

TEST(StepEnv, TakesItsRowOfAGridOfAnySize) {
  auto options = high_up(ActionLevel::kMotors, View::kTruth);
  std::string values;
  for (int i = 0; i < 100; ++i) values += (i > 0 ? ", " : "") + std::to_string(i);
  for (const char* key : {"x_m", "y_m", "z_m", "yaw_deg"}) {
    options.vary += (options.vary.empty() ? "[" : ", ") +
                    ("{key: pose." + std::string(key) + ", values: [" + values + "]}");
  }
  options.vary += "]";
  StepEnv env(options);
  env.reset(12'34'56'78);
  std::vector<std::string> drawn;
  for (const auto& [name, value] : env.drawn()) drawn.push_back(value);
  EXPECT_EQ(drawn, (std::vector<std::string>{"12", "34", "56", "78"}));
}

TEST(StepEnv, RefusesASecondEpisodeUntilTheFirstEnds) {
  StepEnv first(high_up(ActionLevel::kMotors, View::kTruth));
  StepEnv second(high_up(ActionLevel::kMotors, View::kTruth));
  first.reset(1);
  EXPECT_EQ(test::refusal([&] { second.reset(1); }),
            "another environment of this process is in an episode: close or free it first");
  EXPECT_THROW(StepEnv(high_up(ActionLevel::kMotors, View::kTruth)), base::ConfigError);
  first.close();
  EXPECT_NO_THROW(second.reset(1));
}

TEST(StepEnv, HasNoEpisodeAfterAResetThatFailed) {
  auto options = high_up(ActionLevel::kMotors, View::kTruth);
  options.vary = "[{key: vehicle.rotor.thrust_coefficient, values: [-1, 5.84e-6]}]";
  StepEnv env(options);
  env.reset(1);
  EXPECT_THROW(env.reset(2), base::ConfigError);
  EXPECT_EQ(test::refusal([&] { env.step(std::vector<double>(4)); }),
            "there is no episode: the last reset() failed, or there was none");
  EXPECT_NO_THROW(env.reset(3));
}

TEST(StepEnv, RefusesAnActionOfAnotherSizeAndAStepBeforeTheFirstReset) {
  StepEnv env(high_up(ActionLevel::kMotors, View::kTruth));
  const std::vector<double> three(3);
  const std::vector<double> four(4);
  EXPECT_THROW(env.step(four), base::ConfigError);
  env.reset(1);
  EXPECT_THROW(env.step(three), base::ConfigError);
  EXPECT_NO_THROW(env.step(four));
}

}  // namespace
}  // namespace cas::hils
