// SPDX-License-Identifier: BSD-3-Clause
// The experiment of [HILS] Sect. 4 on the virtual clock, in small.
#include "hils/compare/comparison.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "hils/compare/comparison_report.hpp"
#include "hils/compare/comparison_table.hpp"
#include "hils/measure/figure_table.hpp"
#include "tests/support/paths.hpp"

namespace cas::hils {
namespace {

using testing::HasSubstr;

ComparisonPlan small_plan(std::vector<Architecture> architectures) {
  return {.scenarios = {Scenario::load(cas::test::source_dir() + "/config/scenarios/hover.yaml")},
          .variants = make_variants(architectures, {460800}),
          .seeds = {1},
          .warm_up_s = 1,
          .hold_s = 3,
          .virtual_clock = true};
}

std::vector<VariantResult> compare_in(const std::string& name, const ComparisonPlan& plan) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                       ("comparison_" + name + std::to_string(::getpid()));
  std::vector<VariantResult> results = run_comparison(plan, folder, false);
  std::filesystem::remove_all(folder);
  return results;
}

TEST(Comparison, GivesTheLineOnlyToArchitecturesThatHaveOne) {
  const auto variants = make_variants(
      {Architecture::kDirect, Architecture::kSitl, Architecture::kTcas}, {460800, 921600});
  ASSERT_EQ(variants.size(), 4U);
  EXPECT_EQ(variants[0].name(), "DIRECT");
  EXPECT_EQ(variants[1].name(), "SITL");
  EXPECT_EQ(variants[2].name(), "TCAS 460800");
  EXPECT_EQ(variants[3].name(), "TCAS 921600");
}

TEST(Comparison, IsTheSameToTheByteOnTheVirtualClock) {
  const ComparisonPlan plan = small_plan({Architecture::kTs, Architecture::kTcas});
  const auto first = compare_in("first", plan);
  const auto second = compare_in("second", plan);
  EXPECT_EQ(comparison_json(plan, first), comparison_json(plan, second));
  EXPECT_EQ(write_html(comparison_report(plan, first)),
            write_html(comparison_report(plan, second)));
}

TEST(Comparison, AccountsForEveryPacketOfEveryArchitecture) {
  const ComparisonPlan plan = small_plan({kArchitectures.begin(), kArchitectures.end()});
  const std::vector<VariantResult> results = compare_in("all", plan);
  EXPECT_GE(results.size(), kArchitectures.size());
  for (const VariantResult& result : results) {
    ASSERT_EQ(result.runs.size(), 1U);
    EXPECT_TRUE(result.verdicts[0].valid)
        << result.variant.name() << ": " << validity_words(result);
    std::uint64_t lost = 0;  // each has a cause
    for (const auto& [cause, count] : losses_of(result)) lost += count;
    const StreamFigures& rates = result.runs[0].rates;
    EXPECT_EQ(lost, rates.sensor.lost + rates.gps.lost + rates.controls.lost)
        << result.variant.name();
  }
  // The kernel's tick leaves the one thread some 300 packets a second ([HILS] Table 4: 353 of 500).
  const auto result_of = [&results](Architecture architecture) -> const VariantResult& {
    return *std::ranges::find_if(results, [architecture](const VariantResult& result) {
      return result.variant.architecture == architecture;
    });
  };
  const StreamFigures& ts = result_of(Architecture::kTs).runs[0].rates;
  const StreamFigures& tcas = result_of(Architecture::kTcas).runs[0].rates;
  EXPECT_LT(10 * ts.sensor.received, 8 * tcas.sensor.received);
  EXPECT_LT(10 * ts.controls.received, 8 * tcas.controls.received);
  EXPECT_EQ(losses_of(result_of(Architecture::kTs)).begin()->second, ts.sensor.lost);
  EXPECT_EQ(tcas.sensor.lost, 0U);
}

TEST(Comparison, SaysHowManyRunsCountAndHowManyWereFlown) {
  VariantResult result;
  result.runs.resize(3);
  result.runs[1].flight_failure = "arm: refused";
  result.verdicts = {{.valid = true, .passed = true, .failures = {}},
                     {.valid = true, .passed = false, .failures = {"the flight was not completed"}},
                     {.valid = false, .passed = false, .failures = {"the machine was too busy"}}};
  EXPECT_EQ(validity_words(result),
            "2 of 3 runs valid, 2 flown to the end; first remark: the flight was not completed");
}

TEST(Comparison, HasTheWarningsOfEachVariant) {
  const ComparisonPlan plan{.scenarios = {Scenario{}}, .variants = {}, .seeds = {1, 2}};
  VariantResult result{.variant = {.architecture = Architecture::kSitl}};
  result.runs.resize(2);
  result.verdicts.resize(2);
  result.verdicts[0].warnings = {"a mass of 1 g"};
  const std::string text = write_text(comparison_report(plan, {result}));
  EXPECT_THAT(text, HasSubstr("SITL: warning in 1 of 2 flights: a mass of 1 g"));
  const auto json = nlohmann::json::parse(comparison_json(plan, {result}));
  EXPECT_EQ(json.at("variants").at(0).at("warnings"),
            nlohmann::json::parse(R"([{"warning": "a mass of 1 g", "flights": 1}])"));
}

TEST(Comparison, HasEachFigureUnderItsKeyInJson) {
  VariantResult result;
  for (const double p99_us : {1000.0, 3000.0, 9000.0}) {
    result.runs.emplace_back().sensor_to_control = {.count = 5, .p99 = p99_us};
    result.verdicts.emplace_back().valid = p99_us < 9000;
  }
  ComparisonPlan plan;
  plan.scenarios.emplace_back();
  plan.seeds = {1, 2, 3};
  const auto json = nlohmann::json::parse(comparison_json(plan, {result}));
  EXPECT_EQ(json.at("schema"), 2);
  const auto& figures = json.at("variants").at(0).at("figures");
  EXPECT_EQ(figures.size(), figure_table().size());
  EXPECT_EQ(figures.at("sensor_to_control_p99_us").at("mean"), 2000);
  EXPECT_EQ(figures.at("sensor_to_control_p99_us").at("runs"), 2) << "one is not valid";
  EXPECT_TRUE(figures.at("rms_x_m").is_null());
}

/// A run of one scenario among several.
VariantResult run_of(const std::string& scenario, double tilt_deg) {
  VariantResult result{.variant = {.scenario_name = scenario}};
  Measurement& run = result.runs.emplace_back();
  run.strike = {.fault = "gust", .peak_tilt_deg = 40, .hold_tilt_deg = tilt_deg};
  run.responses = {{.name = "step", .size = 4, .rise_s = 1.25}};
  result.verdicts.emplace_back().valid = true;
  return result;
}

TEST(Comparison, OfSeveralScenariosHasOneTableWithAColumnForEach) {
  ComparisonPlan plan;
  plan.scenarios.resize(2);
  plan.seeds = {1};
  std::vector<VariantResult> results{run_of("ours", 17), run_of("stock", 12)};
  results.back().runs.front().firmware = {.autopilot = "PX4", .version = "1.16.0", .lost = 22};
  results.back().runs.front().streamed = false;
  const std::string page = write_markdown(comparison_report(plan, results));
  EXPECT_THAT(page, HasSubstr("| controller | TCAS | stock PX4 v1.16.0 in software |"));
  EXPECT_THAT(page, HasSubstr("| gust: in the hold: largest tilt, deg | 17.00 | 12.00 |"));
  EXPECT_THAT(page, HasSubstr("| step: rise time, s | 1.25 | 1.25 |"));
  EXPECT_THAT(page, HasSubstr("| telemetry: packets missed by their numbers | - | 22 |"));
  EXPECT_THAT(page, HasSubstr("| stock | - | - | not counted |"));
  const auto json = nlohmann::json::parse(comparison_json(plan, results));
  const auto& run = json.at("variants").at(1).at("runs").at(0);
  EXPECT_EQ(run.at("strike").at("hold_tilt_deg"), 12);
  EXPECT_EQ(run.at("responses").at(0).at("rise_s"), 1.25);
}

TEST(Comparison, EndsWithThreeWhereAVariantHasNoRunThatCounts) {
  VariantResult good;
  good.verdicts = {{.valid = false, .passed = false, .failures = {"the machine was too busy"}},
                   {.valid = true, .passed = false, .failures = {}}};
  VariantResult none;
  none.verdicts = {{.valid = false, .passed = false, .failures = {"the machine was too busy"}}};
  EXPECT_EQ(exit_code({good, good}), kExitPassed);
  EXPECT_EQ(exit_code({good, none}), kExitInvalid);
  none.verdicts.clear();
  EXPECT_EQ(exit_code({good, none}), kExitInvalid);
}

TEST(Comparison, TheReportSaysThatARunDoesNotCount) {
  ComparisonPlan plan;
  plan.scenarios.resize(1);
  plan.seeds = {1};
  std::vector<VariantResult> results{run_of("ours", 17)};
  EXPECT_TRUE(write_text(comparison_report(plan, results)).starts_with("All runs valid: "));
  results.at(0).verdicts.at(0).valid = false;
  EXPECT_TRUE(write_text(comparison_report(plan, results)).starts_with("Not all runs valid: "));
}

TEST(Comparison, TellsTheBlockingThreadByItsDelaysWithoutATick) {
  ComparisonPlan plan = small_plan({Architecture::kTs, Architecture::kTcas});
  plan.scenarios.front().drain_tick_ms = 0;
  const auto results = compare_in("delays", plan);
  const Measurement& ts = results.at(0).runs.at(0);
  const Measurement& tcas = results.at(1).runs.at(0);
  EXPECT_GT(ts.sensor_to_control.p50, 1.2 * tcas.sensor_to_control.p50);
  EXPECT_LE(ts.rates.sensor.received, tcas.rates.sensor.received);
}

TEST(Comparison, RefusesAScenarioWithoutAHoldToWarmUp) {
  ComparisonPlan plan = small_plan({Architecture::kTcas});
  std::erase_if(plan.scenarios.front().steps, [](const FlightStep& step) {
    return step.kind == StepKind::kHold && !step.measure;
  });
  EXPECT_THROW(comparison_scenario(plan.scenarios.front(), plan), base::ConfigError);
}

}  // namespace
}  // namespace cas::hils
