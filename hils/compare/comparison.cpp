// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/os/result_file.hpp"
#include "base/time/clock.hpp"
#include "hils/bench/fly.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/programs/batch_progress.hpp"
#include "hils/report/summary_json.hpp"

namespace cas::hils {

namespace {

bool has_line(Architecture architecture) {
  return architecture != Architecture::kDirect && architecture != Architecture::kSitl;
}

/// The hold that comes before the measured one.
FlightStep* warm_up_of(std::vector<FlightStep>& steps) {
  for (std::size_t i = 1; i < steps.size(); ++i) {
    if (steps[i].measure && steps[i - 1].kind == StepKind::kHold) return &steps[i - 1];
  }
  return nullptr;
}

std::string folder_of(const Variant& variant, std::uint64_t seed) {
  std::string name(to_string(variant.architecture));
  if (variant.baud > 0) name += fmt::format("_{}", variant.baud);
  return fmt::format("{}_seed{}", name, seed);
}

RunRequest request_of(const Scenario& scenario, const Variant& variant, std::uint64_t seed,
                      const std::filesystem::path& out, bool keep) {
  if (!variant.scenario_name.empty()) {
    return {.scenario = scenario,
            .architecture = scenario.architecture,
            .seed = seed,
            .keeps_sensors = keep,
            .out = out / "runs" / fmt::format("{}_seed{}", variant.scenario_name, seed)};
  }
  return {.scenario = scenario,
          .architecture = variant.architecture,
          .seed = seed,
          .line_preset = variant.baud > 0 ? fmt::format("baud_{}", variant.baud) : "ideal",
          .keeps_sensors = keep,
          .out = out / "runs" / folder_of(variant, seed)};
}

void run_one(const RunRequest& request, bool keep, VariantResult& result) {
  const RunResult run = evaluate(request, fly(request));
  if (request.clock == Clock::kWall) {
    base::write_result({request.out, "summary.json"}, summary_json(run));
  }
  const auto& [record, figures, verdict] = run.vehicles.front();
  if (result.runs.empty()) {
    result.curves = run_curves(result.variant.name(), request.scenario, record);
  }
  result.runs.push_back(figures);
  result.verdicts.push_back(verdict);
  if (keep) return;
  std::filesystem::remove(record.truth_csv);
  std::filesystem::remove(record.clouds_csv);
  std::filesystem::remove(record.flight_tlog);
}

}  // namespace

std::string Variant::name() const {
  if (!scenario_name.empty()) return scenario_name;
  const std::string name = title_of(architecture);
  return baud > 0 ? fmt::format("{} {}", name, baud) : name;
}

std::vector<Variant> make_variants(const std::vector<Architecture>& architectures,
                                   const std::vector<unsigned>& bauds) {
  std::vector<Variant> variants;
  for (const Architecture architecture : architectures) {
    if (!has_line(architecture)) variants.push_back({.architecture = architecture});
  }
  for (const unsigned baud : bauds) {
    for (const Architecture architecture : architectures) {
      if (has_line(architecture)) variants.push_back({.architecture = architecture, .baud = baud});
    }
  }
  return variants;
}

std::vector<Variant> make_variants(const std::vector<Scenario>& scenarios) {
  std::vector<Variant> variants;
  for (const Scenario& scenario : scenarios) {
    if (scenario.flies_several()) {
      throw base::ConfigError(scenario.file.string() + ": a comparison flies one vehicle");
    }
    if (std::ranges::find(variants, scenario.name, &Variant::scenario_name) != variants.end()) {
      throw base::ConfigError("two of the scenarios have the name '" + scenario.name +
                              "': in a comparison each has one of its own");
    }
    variants.push_back({.architecture = scenario.architecture,
                        .scenario = variants.size(),
                        .scenario_name = scenario.name});
  }
  return variants;
}

Scenario comparison_scenario(const Scenario& scenario, const ComparisonPlan& plan) {
  if (scenario.flies_several()) {
    throw base::ConfigError(scenario.file.string() + ": a comparison flies one vehicle");
  }
  Scenario result = scenario;
  FlightStep* const warm_up = warm_up_of(result.steps);
  if (warm_up == nullptr) {
    throw base::ConfigError(scenario.file.string() +
                            ": a comparison needs a hold before the measured one, to warm up");
  }
  warm_up->duration = base::from_seconds(plan.warm_up_s);
  for (FlightStep& step : result.steps) {
    if (step.measure) step.duration = base::from_seconds(plan.hold_s);
  }
  result.ground_station = true;
  if (result.wake_up.p50_us <= 0) result.wake_up = kUsualWakeUp;
  result.limits = {};  // whether a run counts is judged, not how good it is
  return result;
}

std::vector<VariantResult> run_comparison(const ComparisonPlan& plan,
                                          const std::filesystem::path& out, bool keep) {
  std::vector<Scenario> scenarios = plan.scenarios;
  if (!plan.has_several()) scenarios.front() = comparison_scenario(scenarios.front(), plan);
  std::filesystem::create_directories(out);
  std::vector<VariantResult> results;
  for (const Variant& variant : plan.variants) results.push_back({.variant = variant});
  std::size_t done = 0;
  const base::RunTime begin = base::steady_now();
  const std::size_t all = plan.seeds.size() * plan.variants.size();
  for (const std::uint64_t seed : plan.seeds) {
    for (VariantResult& result : results) {
      const auto elapsed =
          std::chrono::duration_cast<std::chrono::seconds>(base::steady_now() - begin);
      fmt::print(stderr, "{}; {}, seed {}\n", batch_line("compare", done, all, elapsed),
                 result.variant.name(), seed);
      ++done;
      RunRequest request =
          request_of(scenarios[result.variant.scenario], result.variant, seed, out, keep);
      if (plan.virtual_clock && !request.scenario.firmware) request.clock = Clock::kVirtual;
      base::make_result_folder({out, request.out});
      run_one(request, keep, result);
    }
  }
  return results;
}

int exit_code(const std::vector<VariantResult>& results) {
  const auto counts = [](const VariantResult& result) {
    return std::ranges::any_of(result.verdicts,
                               [](const Verdict& verdict) { return verdict.valid; });
  };
  return std::ranges::all_of(results, counts) ? kExitPassed : kExitInvalid;
}

}  // namespace cas::hils
