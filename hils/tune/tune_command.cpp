// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/programs/child_process.hpp"
#include "hils/report/plot.hpp"
#include "hils/run/verbs.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "hils/tune/eval_session.hpp"
#include "hils/tune/tune_report.hpp"
#include "hils/tune/tune_search.hpp"

namespace cas::hils {

namespace fs = std::filesystem;

namespace {

/// When a step of that name of the first vehicle began and ended, by summary.json; s.
std::optional<std::pair<double, double>> stage_of(const fs::path& flight, const std::string& name) {
  const auto summary = nlohmann::json::parse(text_of_file(flight / "summary.json"), nullptr, false);
  const nlohmann::json::json_pointer stages("/vehicles/0/stages");
  if (!summary.is_object() || !summary.contains(stages)) return std::nullopt;
  for (const auto& stage : summary[stages]) {
    if (stage.value("name", "") != name) continue;
    return std::pair{stage.value("begin_s", 0.0), stage.value("end_s", 0.0)};
  }
  return std::nullopt;
}

Series response(const fs::path& flight, const std::string& name, double half_s) {
  Series series{.name = flight.parent_path().filename().string(), .points = {}};
  try {
    const auto stage = stage_of(flight, name);
    if (!stage) return series;
    const std::vector<PoseSample> truth = read_truth(flight / "truth.csv");
    const double begin_s = stage->first + half_s;
    const auto samples =
        between(truth, std::llround((begin_s - 1) * 1e6), std::llround(stage->second * 1e6));
    for (const PoseSample& sample : samples) {
      series.points.emplace_back(1e-6 * static_cast<double>(sample.time_us) - begin_s,
                                 sample.pose.x_m - truth.front().pose.x_m);
    }
  } catch (const base::ConfigError&) {
    // the flight left nothing to draw
  }
  return series;
}

/// The true northward motion after each `trajectory: {shape: step}` of a scenario, in two flights
/// of it: a plot for each step, both curves from its beginning. A flight that did not come so far,
/// or left no truth.csv and summary.json, has no curve.
std::vector<Plot> step_plots(const fs::path& scenario, const fs::path& before,
                             const fs::path& after) {
  const Scenario flown = Scenario::load(scenario);
  std::vector<Plot> plots;
  for (const FlightStep& step : flown.steps) {
    if (step.kind != StepKind::kTrajectory || step.trajectory.shape != fcu::PatternShape::kSteps) {
      continue;
    }
    const std::string name(phase_of(step));
    Plot plot{.title = after.filename().string() + ", " + name,
              .x_label = "time since the step, s",
              .y_label = "north, m"};
    for (const fs::path& flight : {before, after}) {
      Series series = response(flight, name, step.trajectory.period_s);
      if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    if (!plot.series.empty()) plots.push_back(std::move(plot));
  }
  return plots;
}

/// Flies each scenario of the search once more with a whole report.
/// @param before_or_after  folder below `out`
void fly_reports(const TuneStudy& study, const TuneFlights& flights, const fs::path& out,
                 const char* before_or_after, const std::vector<std::string>& values) {
  for (std::size_t i = 0; i < study.scenarios.size(); ++i) {
    const fs::path own = out / before_or_after / study.scenarios[i].name;
    std::string text;
    for (const auto& [key, value] : study.values_of(values)) {
      text += fmt::format("\"{}\": {}\n", key, value);
    }
    const fs::path flown = own / "values.yaml";
    if (fs::exists(own / "report.html") && fs::exists(flown) && text_of_file(flown) == text) {
      continue;
    }
    base::remove_result_folder({out, own});  // of other values
    base::make_result_folder({out, own});
    write_scenario(flights.scenario(i), study.values_of(values), {}, own);
    std::vector<std::string> command{kSameProgram, "run", (own / "scenario.yaml").string(),
                                     "--architecture", std::string(to_string(study.architecture))};
    if (study.architecture != Architecture::kDirect) command.emplace_back("--virtual");
    command.insert(command.end(),
                   {"--seed", std::to_string(study.seeds.front()), "--out", own.string()});
    ChildProcess process({.name = "the process of a run",
                          .arguments = std::move(command),
                          .log_file = own / "log.txt"});
    process.wait_exit(base::from_seconds(study.deadline_s));
    base::write_result({own, "values.yaml"}, text, base::Durability::kDisk);
  }
}

int run_tune(const std::string& study_file, const fs::path& out, std::size_t jobs) {
  const fs::path file = base::find_config(study_file);
  const TuneStudy study = TuneStudy::load(file);
  if (!has_search()) search({}, {});  // says how to get it, before anything is flown
  TuneFlights flights(study, file, out, jobs);
  const TuneResult result = tune(study, flights);

  std::vector<std::size_t> all(result.candidates.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  base::write_result({out, "candidates.csv"}, candidates_csv(study, result, all),
                     base::Durability::kDisk);
  base::write_result({out, "front.csv"}, candidates_csv(study, result, result.front),
                     base::Durability::kDisk);
  const Candidate& best = result.candidates[result.best];
  base::write_result({out, "gains.yaml"}, gains_yaml(study, best), base::Durability::kDisk);
  base::write_result({out, "gains.params"}, gains_params(study, best), base::Durability::kDisk);
  fly_reports(study, flights, out, "before", study.before());
  fly_reports(study, flights, out, "after", best.values);
  std::vector<Plot> steps;
  for (std::size_t i = 0; i < study.scenarios.size(); ++i) {
    const std::string& name = study.scenarios[i].name;
    for (Plot& plot :
         step_plots(flights.scenario(i), out / "before" / name, out / "after" / name)) {
      steps.push_back(std::move(plot));
    }
  }
  const Document report = tune_report(study, result, steps);
  base::write_result({out, "tune.html"}, write_html(report), base::Durability::kDisk);
  fmt::print("{}\nResults: {}\n", write_text(report), out.string());
  return result.best != 0 ? kExitPassed : kExitLimitsMissed;
}

}  // namespace

base::cli::Verb add_tune(CLI::App& app) {
  struct Flags {
    std::string study;
    std::string out;
    std::size_t jobs = std::max(1U, std::thread::hardware_concurrency());
  };
  const auto flags = std::make_shared<Flags>();
  CLI::App* tune =
      app.add_subcommand("tune", "Search gains, or any numbers, for what a study weighs");
  tune->add_option("STUDY", flags->study, "Study file (docs/use/tune.md)")->required();
  tune->add_option("--out", flags->out, "Folder for the results (the last, if several)")
      ->required()
      ->take_last();
  tune->add_option("--jobs", flags->jobs, "Flights at once (as many as processors)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 4096));
  return {tune, [flags] { return run_tune(flags->study, fs::absolute(flags->out), flags->jobs); }};
}

base::cli::Verb add_eval(CLI::App& app) {
  struct Flags {
    std::string study;
    std::string scratch;  ///< empty: the system's
    std::size_t jobs = 1;
    bool describe = false;
  };
  const auto flags = std::make_shared<Flags>();
  CLI::App* eval = app.add_subcommand(
      "eval", "Fly a study for each line of parameters on standard input, for an optimiser");
  eval->add_option("STUDY", flags->study, "Study file (docs/use/sweep.md)")->required();
  eval->add_option("--jobs", flags->jobs, "Flights at once, answered as they end (1)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 4096));
  eval->add_option("--scratch", flags->scratch,
                   "Folder for the files of flights under way (that for temporary files)");
  eval->add_flag("--describe", flags->describe,
                 "Say on one line which parameters and figures there are, and end");
  return {eval, [flags] {
            return eval_lines({.study = base::find_config(flags->study),
                               .scratch = flags->scratch.empty() ? fs::temp_directory_path()
                                                                 : fs::absolute(flags->scratch),
                               .jobs = flags->jobs,
                               .describe = flags->describe});
          }};
}

}  // namespace cas::hils
