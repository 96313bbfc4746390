// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/text.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/run/verbs.hpp"
#include "hils/sweep/job_array.hpp"
#include "hils/sweep/row_again.hpp"
#include "hils/sweep/row_flight.hpp"
#include "hils/sweep/share_limits.hpp"
#include "hils/sweep/sqlite_file.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "hils/sweep/sweep_report.hpp"
#include "hils/sweep/sweep_runner.hpp"
#include "hils/sweep/sweep_view.hpp"

namespace cas::hils {

namespace fs = std::filesystem;

namespace {

using base::cli::Verb;

struct Flags {
  std::string study;
  std::string folder;
  std::optional<std::size_t> jobs;
  std::string chunk = "1/1";
  std::string scratch;
  bool retry = false;
  bool slurm = false;
  JobArrayOptions array;
  std::size_t row = 0;
  std::string against;
  std::vector<std::string> maps;
  std::size_t again = 10;
};

std::pair<std::string, std::string> parse_map(const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos || comma == 0 || comma + 1 == text.size()) {
    throw base::ConfigError("--map '" + text + "' is not two parameters such as mass,wind");
  }
  return {text.substr(0, comma), text.substr(comma + 1)};
}

void print_status(const SweepFolder& sweep) {
  std::map<std::string, std::size_t> outcomes;
  std::vector<bool> done(sweep.table.rows.size(), false);
  std::map<std::size_t, RowOutcome> outcome_of;
  double wall_s = 0;
  double most_mib = 0;
  std::size_t lines = 0;
  sweep.for_each_result([&](RowResult&& result) {
    done[result.row - 1] = true;
    RowOutcome& known = outcome_of.try_emplace(result.row, result.outcome).first->second;
    if (is_broken(known) || !is_broken(result.outcome)) known = result.outcome;
    wall_s += result.machine.wall_s;
    most_mib = std::max(most_mib, result.machine.max_rss_mib);
    ++lines;
  });
  for (const auto& [row, outcome] : outcome_of) ++outcomes[std::string(to_string(outcome))];
  fmt::print("{}: {} of {} runs flown\n", sweep.study.name, outcome_of.size(), done.size());
  for (const auto& [outcome, number] : outcomes) fmt::print("  {:<8} {}\n", outcome, number);
  const auto missing = std::ranges::find(done, false);
  if (missing != done.end()) fmt::print("  first missing: row {}\n", missing - done.begin() + 1);
  if (lines > 0) {
    fmt::print("  {:.2f} s a run and process, at most {:.1f} MiB\n",
               wall_s / static_cast<double>(lines), most_mib);
  }
}

void print_row(const SweepFolder& sweep, std::size_t number) {
  const TableRow& row = sweep.row(number);
  const RowResult result = sweep.results(number, number + 1).front();
  fmt::print("Row {}, point {}, seed {}\n", row.row, row.point, row.seed);
  for (std::size_t i = 0; i < row.values.size(); ++i) {
    fmt::print("  {} = {}\n", sweep.table.names[i], row.values[i]);
  }
  if (result.row == 0) {
    fmt::print("It has not been flown.\n");
  } else {
    fmt::print("Outcome: {}{}\n", to_string(result.outcome),
               result.cause.empty() ? "" : ": " + result.cause);
    for (const std::string& warning : result.warnings) fmt::print("  warning: {}\n", warning);
    for (std::size_t i = 0; i < std::min(result.figures.size(), sweep.figures.size()); ++i) {
      if (std::isfinite(result.figures[i])) {
        fmt::print("  {} = {}\n", sweep.figures[i], result.figures[i]);
      }
    }
  }
  write_row_again(sweep, number);
  fmt::print("Again, with its report:\n  {}\n",
             base::joined(command_again(sweep, number), " ", shell_word));
  if (result.truth_sha256.empty()) return;
  const Scenario scenario = Scenario::load(sweep.again(number) / "scenario.yaml");
  std::string files;
  for (const ScenarioVehicle& vehicle : scenario.vehicles) {
    const std::string name = scenario.flies_several() ? "truth_" + vehicle.name : "truth";
    files += " " + shell_word((sweep.again(number) / (name + ".csv")).string());
  }
  fmt::print("The same bytes: cat{} | sha256sum\n  {}\n", files, result.truth_sha256);
}

/// Writes the files of `collect`. @return exit code
int collect_sweep(const fs::path& folder, const Flags& flags) {
  const SweepView view = SweepView::of(SweepFolder::open(folder));
  refuse_rows_of_boards(view.sweep);
  std::optional<SweepView> before;
  if (!flags.against.empty()) before = SweepView::of(SweepFolder::open(flags.against));
  SweepPage page;
  page.before = before ? &*before : nullptr;
  for (const std::string& map : flags.maps) page.maps.push_back(parse_map(map));
  const SweepCounts counts = view.counts();
  const std::vector<ShareCheck> checks = check_shares(view.sweep.study.limits, counts);
  constexpr std::size_t kWorst = 10;
  page.worst = worst_rows(view, std::max(kWorst, flags.again));
  base::write_result({folder, "results.csv"}, view.sweep.results_csv(view.results),
                     base::Durability::kDisk);
  base::write_result({folder, "machine.csv"}, view.sweep.machine_csv_of(view.results),
                     base::Durability::kDisk);
  write_sqlite(view, folder / "sweep.sqlite");
  base::write_result({folder, "junit.xml"},
                     sweep_junit(view.sweep.study.name, counts, checks, warnings_of(view.results)),
                     base::Durability::kDisk);
  page.flown_again = fly_again(
      view.sweep,
      {page.worst.begin(),
       page.worst.begin() + static_cast<std::ptrdiff_t>(std::min(flags.again, page.worst.size()))},
      1);
  const Document report = sweep_report(view, checks, page);
  base::write_result({folder, "sweep.html"}, write_html(report), base::Durability::kDisk);
  fmt::print("{}\nResults: {}\n", write_text(report), folder.string());
  if (counts.flown < counts.rows) return kExitInvalid;
  return std::ranges::all_of(checks, &ShareCheck::kept) ? kExitPassed : kExitLimitsMissed;
}

int run_part(const SweepFolder& sweep, const SweepRunOptions& options) {
  const SweepRunResult result = run_sweep(sweep, options);
  if (result.all_refused) throw base::ConfigError(result.first_cause);
  fmt::print("{} of {}: {} runs, {} of them flown now, {} without a verdict{}\n  {}\n",
             options.chunk.name(), sweep.study.name, result.rows, result.flown, result.unjudged,
             result.first_cause.empty() ? "" : " (" + result.first_cause + ")",
             sweep.chunk_csv(options.chunk).string());
  return kExitPassed;
}

int run_rest(const Flags& flags) {
  const SweepFolder sweep = SweepFolder::open(flags.folder);
  if (flags.slurm) {
    JobArrayOptions array = flags.array;
    array.jobs = flags.jobs.value_or(usual_jobs(sweep));
    submit_job_array(sweep, array);
    return kExitPassed;
  }
  return run_part(sweep,
                  {.chunk = Chunk::parse(flags.chunk),
                   .jobs = flags.jobs.value_or(usual_jobs(sweep)),
                   .scratch = flags.scratch.empty() ? fs::path() : fs::absolute(flags.scratch),
                   .retry = flags.retry});
}

SweepFolder plan_sweep(const Flags& flags) {
  if (flags.study.empty() || flags.folder.empty()) {
    throw base::ConfigError(
        "sweep takes STUDY.yaml and --out DIR, or one of plan, run, status, show and collect");
  }
  SweepFolder sweep = SweepFolder::plan(base::find_config(flags.study), flags.folder);
  fmt::print("{}: {} runs in {}\n", sweep.study.name, sweep.table.rows.size(),
             (sweep.path / "table.csv").string());
  return sweep;
}

/// Plan, run and collect in one. @return exit code
int fly_sweep(const Flags& flags) {
  const SweepFolder sweep = plan_sweep(flags);
  run_part(sweep, {.jobs = flags.jobs.value_or(usual_jobs(sweep))});
  return collect_sweep(sweep.path, flags);
}

void add_jobs(CLI::App& command, Flags& flags) {
  command
      .add_option("--jobs", flags.jobs, "Runs at once (as many as processors; of stock firmware 1)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 4096));
}

void add_pages(CLI::App& command, Flags& flags) {
  command.add_option("--against", flags.against,
                     "Folder of another sweep: what became worse, with a test for chance");
  command
      .add_option("--map", flags.maps,
                  "A,B: a success map over these two parameters, besides the usual ones")
      ->allow_extra_args(false);
  command
      .add_option("--again", flags.again,
                  "Flies so many of the worst runs again for their reports (10)")
      ->check(base::cli::whole_number);
}

void add_run_options(CLI::App& run, Flags& flags) {
  add_jobs(run, flags);
  run.add_option("--chunk", flags.chunk, "K/N: the K-th of N parts alone (1/1)");
  run.add_option("--scratch", flags.scratch, "Folder for the files of runs under way (DIR/work)");
  run.add_flag("--retry", flags.retry, "Fly runs that died or hung once more");
  run.add_flag("--slurm", flags.slurm,
               "Write and submit one job array of Slurm for what has not been flown");
  run.add_option("--partition", flags.array.partition, "Partition of the job array");
  run.add_option("--chunks", flags.array.chunks, "Parts of the job array (by --chunk-minutes)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 1'000'000));
  run.add_option("--chunk-minutes", flags.array.chunk_minutes, "How long a part shall take (10)")
      ->check(CLI::Range(0.01, 1e5));
  run.add_option("--run-seconds", flags.array.run_seconds,
                 "How long a run takes (as measured so far, else 1)")
      ->check(CLI::Range(1e-3, 1e6));
}

using Kept = std::shared_ptr<Flags>;

Verb add_plan(CLI::App& sweep, const Kept& kept) {
  CLI::App* plan = sweep.add_subcommand("plan", "Write the table of runs, and fly nothing");
  plan->add_option("STUDY", kept->study, "Study file")->required();
  plan->add_option("--out", kept->folder, "Folder of the sweep (the last, if several)")
      ->required()
      ->take_last();
  return {plan, [kept] {
            plan_sweep(*kept);
            return kExitPassed;
          }};
}

/// A verb about a folder that was planned.
CLI::App* add_of_folder(CLI::App& sweep, const Kept& kept, const char* name,
                        const char* description) {
  CLI::App* verb = sweep.add_subcommand(name, description);
  verb->add_option("DIR", kept->folder, "Folder of the sweep")->required();
  return verb;
}

Verb add_run(CLI::App& sweep, const Kept& kept) {
  CLI::App* run = add_of_folder(sweep, kept, "run", "Fly what has not been flown");
  add_run_options(*run, *kept);
  return {run, [kept] { return run_rest(*kept); }};
}

Verb add_status(CLI::App& sweep, const Kept& kept) {
  return {add_of_folder(sweep, kept, "status", "Say how far a sweep is"), [kept] {
            print_status(SweepFolder::open(kept->folder));
            return kExitPassed;
          }};
}

Verb add_show(CLI::App& sweep, const Kept& kept) {
  CLI::App* show =
      add_of_folder(sweep, kept, "show", "Print a row, and the command that flies it again");
  show->add_option("ROW", kept->row, "Number of the row, from 1")
      ->required()
      ->check(base::cli::whole_number);
  return {show, [kept] {
            print_row(SweepFolder::open(kept->folder), kept->row);
            return kExitPassed;
          }};
}

Verb add_collect(CLI::App& sweep, const Kept& kept) {
  CLI::App* collect =
      add_of_folder(sweep, kept, "collect", "Make one table, one database and one page of a sweep");
  add_pages(*collect, *kept);
  return {collect, [kept] { return collect_sweep(fs::absolute(kept->folder), *kept); }};
}

/// The verb that the runner starts its processes with; hidden from users.
Verb add_fly(CLI::App& sweep, const Kept& kept) {
  CLI::App* fly = sweep.add_subcommand("fly", "Fly the task of a folder in this process");
  fly->group("");
  fly->add_option("FOLDER", kept->folder, "Folder with task.json")->required();
  return {fly, [kept] { return fly_row(kept->folder); }};
}

/// The verbs behind `sweep`.
std::vector<Verb> add_verbs(CLI::App& sweep, const Kept& kept) {
  return {add_plan(sweep, kept), add_run(sweep, kept),     add_status(sweep, kept),
          add_show(sweep, kept), add_collect(sweep, kept), add_fly(sweep, kept)};
}

}  // namespace

Verb add_sweep(CLI::App& app) {
  const auto kept = std::make_shared<Flags>();
  Flags& flags = *kept;
  CLI::App* sweep = app.add_subcommand(
      "sweep", "Fly a scenario many times with other values: plan, run and collect in one");
  sweep->require_subcommand(0, 1);
  sweep->add_option("STUDY", flags.study, "Study file");
  sweep->add_option("--out", flags.folder, "Folder of the sweep (the last, if several)")
      ->take_last();
  add_jobs(*sweep, flags);
  add_pages(*sweep, flags);
  return {sweep, [kept, verbs = add_verbs(*sweep, kept)] {
            const Verb* verb = base::cli::find_asked(verbs);
            return verb != nullptr ? verb->run() : fly_sweep(*kept);
          }};
}

}  // namespace cas::hils
