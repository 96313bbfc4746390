// SPDX-License-Identifier: BSD-3-Clause
// Steps of an environment by the C++ loop, without Python: a step is 2 ms of simulated time.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "hils/env/step_env.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace cas::hils;

StepEnvOptions options(Stand stand, View view) {
  return {.setup = "{vehicle: " + cas::test::source_dir() +
                   "/config/vehicles/iris_paper.yaml, sensors: table1, pose: {z_m: 100}}",
          .vary = {},
          .stand = stand,
          .view = view};
}

/// Near hover, an episode of 10 s after the other.
void step_env(benchmark::State& state, Stand stand, View view) {
  constexpr int kEpisode = 5000;
  StepEnv env(options(stand, view));
  std::vector<double> action(4, stand == Stand::kMotors ? 0.62 : 0.0);
  if (stand == Stand::kRates || stand == Stand::kAttitude) action[3] = 0.54;
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
  StepEnv env(options(Stand::kMotors, View::kTruth));
  for (auto _ : state) env.reset(1);
}

BENCHMARK_CAPTURE(step_env, motors_truth, Stand::kMotors, View::kTruth);
BENCHMARK_CAPTURE(step_env, motors_sensors, Stand::kMotors, View::kSensors);
BENCHMARK_CAPTURE(step_env, rates_sensors, Stand::kRates, View::kSensors);
BENCHMARK_CAPTURE(step_env, attitude_sensors, Stand::kAttitude, View::kSensors);
BENCHMARK_CAPTURE(step_env, velocity_sensors, Stand::kVelocity, View::kSensors);
BENCHMARK(reset_env);

}  // namespace

BENCHMARK_MAIN();
