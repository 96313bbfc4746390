// SPDX-License-Identifier: BSD-3-Clause
// Every shipped scenario flown on the virtual clock.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "base/config/config.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/virtual/virtual_run.hpp"
#include "tests/hils/report/run_text.hpp"
#include "tests/support/paths.hpp"

namespace cas::hils {
namespace {

struct Flown {
  Measurement figures;
  Verdict verdict;
  std::string text;
};

/// @param faults  list of them, instead of the scenario's; empty: those
Flown fly(const std::string& name, const std::string& faults = {}) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("scenario_" + name + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  RunRequest request{
      .scenario = Scenario::load(cas::test::source_dir() + "/config/scenarios/" + name + ".yaml"),
      .architecture = Architecture::kTcas,
      .seed = 1,
      .out = folder};
  if (!faults.empty()) {
    request.scenario.faults = parse_scenario_faults(
        base::ConfigNode::parse("faults: " + faults).at("faults"), request.scenario.line);
  }
  const RunRecord record = run_on_virtual_clock(request).front();
  Flown flown{.figures = measure(request, record), .verdict = {}, .text = {}};
  flown.verdict = judge(flown.figures, request.scenario.limits);
  flown.text = test::run_text(flown.figures, flown.verdict);
  std::filesystem::remove_all(folder);
  return flown;
}

bool has_fault(const Measurement& figures, const std::string& name, double length_s) {
  return std::ranges::any_of(figures.faults, [&](const auto& fault) {
    return fault.name == name && fault.end &&
           std::abs(base::to_seconds(*fault.end - fault.begin) - length_s) < 0.06;
  });
}

std::uint64_t lost(const Measurement& figures, const std::string& cause) {
  std::uint64_t sum = 0;
  for (const PathAccount& path : figures.paths) {
    const auto found = path.losses.find(cause);
    if (found != path.losses.end()) sum += found->second;
  }
  return sum;
}

class ShippedScenario : public testing::TestWithParam<const char*> {};

TEST_P(ShippedScenario, Passes) {
  const Flown flown = fly(GetParam());
  EXPECT_TRUE(flown.verdict.passed) << flown.text;
}

INSTANTIATE_TEST_SUITE_P(Each, ShippedScenario,
                         testing::Values("steps", "figure_eight", "pixhawk", "plane", "quadplane",
                                         "aerosonde", "wind", "village", "rotor_weak"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Scenario, LineLossNamesTheLineForEachLostPacket) {
  const Flown flown = fly("line_loss");
  EXPECT_TRUE(flown.verdict.passed) << flown.text;
  EXPECT_TRUE(has_fault(flown.figures, "line loses packets", 10)) << flown.text;
  const StreamFigures& rates = flown.figures.rates;
  const std::uint64_t all = rates.sensor.lost + rates.gps.lost + rates.controls.lost;
  EXPECT_GT(all, 100U);
  EXPECT_EQ(lost(flown.figures, "on the serial line"), all);
}

TEST(Scenario, UnplugComesBackAfterTheDeviceAndAfterCasd) {
  const Flown flown = fly("unplug");
  EXPECT_TRUE(flown.verdict.passed) << flown.text;
  EXPECT_TRUE(has_fault(flown.figures, "plug pulled", 0.3));
  EXPECT_TRUE(has_fault(flown.figures, "casd killed", 0.3));
}

TEST(Scenario, GpsLossIsFlownThrough) {
  const Flown flown = fly("gps_loss");
  EXPECT_TRUE(flown.verdict.passed) << flown.text;
  // One and a half seconds at 5 Hz are missing, and no packet was lost for it.
  EXPECT_NEAR(static_cast<double>(flown.figures.rates.gps.sent), 143, 1) << flown.text;
  EXPECT_EQ(flown.figures.rates.gps.lost, 0U);
}

TEST(Scenario, AReversedElevatorBringsThePlaneDown) {
  const Flown flown = fly("plane",
                          "[{name: reversed, when: phase == takeoff and height > 10, surface: "
                          "{name: elevator, reversed: true}}]");
  EXPECT_TRUE(flown.verdict.valid) << flown.text;
  EXPECT_FALSE(flown.verdict.passed) << flown.text;
  EXPECT_NE(flown.text.find("the vehicle hit the ground at "), std::string::npos) << flown.text;
}

TEST(Scenario, GainTuningShowsWhatTheGainChanged) {
  const Flown flown = fly("gain_tuning");
  EXPECT_TRUE(flown.verdict.passed) << flown.text;
  ASSERT_EQ(flown.figures.responses.size(), 2U);
  const StepResponse& before = flown.figures.responses[0];
  const StepResponse& after = flown.figures.responses[1];
  ASSERT_TRUE(before.rise_s && after.rise_s) << flown.text;
  EXPECT_LT(*after.rise_s, *before.rise_s) << flown.text;
}

}  // namespace
}  // namespace cas::hils
