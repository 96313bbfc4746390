// SPDX-License-Identifier: BSD-3-Clause
// Steps of an environment by the C++ loop, without Python: a step is 2 ms of simulated time.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "hils/env/step_env.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace cas::hils;

StepEnvOptions options(ActionLevel action_level, View view) {
  return {.setup = "{vehicle: " + cas::test::source_dir() +
                   "/config/vehicles/iris_paper.yaml, sensors: table1, pose: {z_m: 100}}",
          .vary = {},
          .action_level = action_level,
          .view = view};
}

/// Near hover, an episode of 10 s after the other.
void step_env(benchmark::State& state, ActionLevel action_level, View view) {
  constexpr int kEpisode = 5000;
  StepEnv env(options(action_level, view));
  std::vector<double> action(4, action_level == ActionLevel::kMotors ? 0.62 : 0.0);
  if (action_level == ActionLevel::kRates || action_level == ActionLevel::kAttitude)
    action[3] = 0.54;
  std::vector<double> observation(env.observation_names().size());
  int steps = 0;
  for (auto _ : state) {
    if (steps++ % kEpisode == 0) env.reset(1);
    env.step(action);
    env.observe(observation);
    benchmark::DoNotOptimize(observation.data());
  }
  state.SetItemsProcessed(state.iterations());
}

void reset_env(benchmark::State& state) {
  StepEnv env(options(ActionLevel::kMotors, View::kTruth));
  for (auto _ : state) env.reset(1);
}

BENCHMARK_CAPTURE(step_env, motors_truth, ActionLevel::kMotors, View::kTruth);
BENCHMARK_CAPTURE(step_env, motors_sensors, ActionLevel::kMotors, View::kSensors);
BENCHMARK_CAPTURE(step_env, rates_sensors, ActionLevel::kRates, View::kSensors);
BENCHMARK_CAPTURE(step_env, attitude_sensors, ActionLevel::kAttitude, View::kSensors);
BENCHMARK_CAPTURE(step_env, velocity_sensors, ActionLevel::kVelocity, View::kSensors);
BENCHMARK(reset_env);

}  // namespace

BENCHMARK_MAIN();
