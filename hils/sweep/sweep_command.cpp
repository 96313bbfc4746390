// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/programs/child_process.hpp"
#include "hils/sweep/row_again.hpp"
#include "hils/sweep/row_flight.hpp"
#include "hils/sweep/share_limits.hpp"
#include "hils/sweep/slurm_script.hpp"
#include "hils/sweep/sqlite_file.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "hils/sweep/sweep_report.hpp"
#include "hils/sweep/sweep_runner.hpp"
#include "hils/sweep/sweep_view.hpp"

namespace cas::hils {

namespace fs = std::filesystem;

struct SweepCommand::Flags {
  CLI::App* sweep = nullptr;
  CLI::App* plan = nullptr;
  CLI::App* run = nullptr;
  CLI::App* status = nullptr;
  CLI::App* show = nullptr;
  CLI::App* collect = nullptr;
  CLI::App* fly = nullptr;

  std::string study;
  std::string folder;
  std::size_t jobs = std::max(1U, std::thread::hardware_concurrency());
  std::string chunk = "1/1";
  std::string scratch;
  bool retry = false;
  bool slurm = false;
  std::string partition;
  std::size_t chunks = 0;  ///< of the job array; 0: by chunk_minutes
  double chunk_minutes = 10;
  double run_seconds = 0;  ///< 0: as measured, or 1
  std::size_t row = 0;
  std::string against;
  std::vector<std::string> maps;
  std::size_t again = 10;
};

namespace {

constexpr double kUsualRunSeconds = 1;

/// A path as a shell takes it.
std::string shell_word(const std::string& text) {
  const bool plain = std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("/._-+:,=@").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain && !text.empty()) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

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
    for (std::size_t i = 0; i < std::min(result.figures.size(), sweep.figures.size()); ++i) {
      if (std::isfinite(result.figures[i])) {
        fmt::print("  {} = {}\n", sweep.figures[i], result.figures[i]);
      }
    }
  }
  write_row_again(sweep, number);
  std::string line;
  for (const std::string& word : command_again(sweep, number)) {
    line += (line.empty() ? "" : " ") + shell_word(word);
  }
  fmt::print("Again, with its report:\n  {}\n", line);
  if (result.truth_sha256.empty()) return;
  const Scenario scenario = Scenario::load(sweep.again(number) / "scenario.yaml");
  std::string files;
  for (const ScenarioVehicle& vehicle : scenario.vehicles) {
    const std::string name = scenario.flies_several() ? "truth_" + vehicle.name : "truth";
    files += " " + shell_word((sweep.again(number) / (name + ".csv")).string());
  }
  fmt::print("The same bytes: cat{} | sha256sum\n  {}\n", files, result.truth_sha256);
}

/// Chunks of `n` in which a row has not been flown.
std::vector<std::size_t> missing_chunks(const SweepFolder& sweep, std::size_t n) {
  std::vector<bool> done(sweep.table.rows.size(), false);
  sweep.for_each_result([&](RowResult&& result) { done[result.row - 1] = true; });
  std::vector<std::size_t> missing;
  for (std::size_t k = 1; k <= n; ++k) {
    const auto [first, last] = rows_of_chunk(done.size(), k, n);
    for (std::size_t row = first; row < last; ++row) {
      if (done[row - 1]) continue;
      missing.push_back(k);
      break;
    }
  }
  return missing;
}

double measured_run_seconds(const SweepFolder& sweep) {
  double wall_s = 0;
  std::size_t runs = 0;
  sweep.for_each_result([&](RowResult&& result) {
    wall_s += result.machine.wall_s;
    ++runs;
  });
  return runs > 0 ? wall_s / static_cast<double>(runs) : kUsualRunSeconds;
}

/// Says how many chunks the first job array has.
fs::path chunks_file(const SweepFolder& sweep) { return sweep.path / "slurm" / "chunks.txt"; }

/// How many chunks a job array has: those of the first one, whose jobs may still run. @param asked
/// by the user; 0: `usual`
std::size_t chunks_of_array(const SweepFolder& sweep, std::size_t asked, std::size_t usual) {
  const fs::path file = chunks_file(sweep);
  const std::size_t rows = sweep.table.rows.size();
  if (!fs::exists(file)) return std::min(asked > 0 ? asked : usual, rows);
  std::size_t chunks = 0;
  std::istringstream(text_of_file(file)) >> chunks;
  if (chunks < 1 || chunks > rows) {
    throw base::ConfigError(
        fmt::format("{}: is a number of chunks from 1 to {}", file.string(), rows));
  }
  if (asked > 0 && std::min(asked, rows) != chunks) {
    throw base::ConfigError(
        fmt::format("{}: sweep.sbatch was written for {} chunks, whose jobs may still run; leave "
                    "out --chunks, or remove this file when none does",
                    file.string(), chunks));
  }
  return chunks;
}

/// The program of that name on PATH; empty where there is none.
fs::path on_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty()) continue;
    const fs::path file = fs::path(folder) / name;
    if (::access(file.c_str(), X_OK) == 0 && !fs::is_directory(file)) return file;
  }
  return {};
}

}  // namespace

SweepCommand::SweepCommand(CLI::App& app) : flags_(std::make_unique<Flags>()) {
  SweepCommand::Flags& flags = *flags_;
  const auto jobs = [&flags](CLI::App* command) {
    command->add_option("--jobs", flags.jobs, "Runs at once (as many as processors)")
        ->check(base::cli::whole_number)
        ->check(CLI::Range(1, 4096));
  };
  const auto pages = [&flags](CLI::App* command) {
    command->add_option("--against", flags.against,
                        "Folder of another sweep: what became worse, with a test for chance");
    command
        ->add_option("--map", flags.maps,
                     "A,B: a success map over these two parameters, besides the usual ones")
        ->allow_extra_args(false);
    command
        ->add_option("--again", flags.again,
                     "Flies so many of the worst runs again for their reports (10)")
        ->check(base::cli::whole_number);
  };

  flags.sweep = app.add_subcommand(
      "sweep", "Fly a scenario many times with other values: plan, run and collect in one");
  flags.sweep->require_subcommand(0, 1);
  flags.sweep->add_option("STUDY", flags.study, "Study file");
  flags.sweep->add_option("--out", flags.folder, "Folder of the sweep (the last, if several)")
      ->take_last();
  jobs(flags.sweep);
  pages(flags.sweep);

  flags.plan = flags.sweep->add_subcommand("plan", "Write the table of runs, and fly nothing");
  flags.plan->add_option("STUDY", flags.study, "Study file")->required();
  flags.plan->add_option("--out", flags.folder, "Folder of the sweep (the last, if several)")
      ->required()
      ->take_last();

  flags.run = flags.sweep->add_subcommand("run", "Fly what has not been flown");
  flags.run->add_option("DIR", flags.folder, "Folder of the sweep")->required();
  jobs(flags.run);
  flags.run->add_option("--chunk", flags.chunk, "K/N: the K-th of N parts alone (1/1)");
  flags.run->add_option("--scratch", flags.scratch,
                        "Folder for the files of runs under way (DIR/work)");
  flags.run->add_flag("--retry", flags.retry, "Fly runs that died or hung once more");
  flags.run->add_flag("--slurm", flags.slurm,
                      "Write and submit one job array of Slurm for what has not been flown");
  flags.run->add_option("--partition", flags.partition, "Partition of the job array");
  flags.run->add_option("--chunks", flags.chunks, "Parts of the job array (by --chunk-minutes)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 1'000'000));
  flags.run->add_option("--chunk-minutes", flags.chunk_minutes, "How long a part shall take (10)")
      ->check(CLI::Range(0.01, 1e5));
  flags.run
      ->add_option("--run-seconds", flags.run_seconds,
                   "How long a run takes (as measured so far, else 1)")
      ->check(CLI::Range(1e-3, 1e6));

  flags.status = flags.sweep->add_subcommand("status", "Say how far a sweep is");
  flags.status->add_option("DIR", flags.folder, "Folder of the sweep")->required();

  flags.show =
      flags.sweep->add_subcommand("show", "Print a row, and the command that flies it again");
  flags.show->add_option("DIR", flags.folder, "Folder of the sweep")->required();
  flags.show->add_option("ROW", flags.row, "Number of the row, from 1")
      ->required()
      ->check(base::cli::whole_number);

  flags.collect = flags.sweep->add_subcommand(
      "collect", "Make one table, one database and one page of a sweep");
  flags.collect->add_option("DIR", flags.folder, "Folder of the sweep")->required();
  pages(flags.collect);

  flags.fly = flags.sweep->add_subcommand("fly", "Fly the task of a folder in this process");
  flags.fly->group("");  // of the runner, for its processes
  flags.fly->add_option("FOLDER", flags.folder, "Folder with task.json")->required();
}

SweepCommand::~SweepCommand() = default;

bool SweepCommand::parsed() const { return flags_->sweep->parsed(); }

namespace {

/// Writes what `collect` writes. @return exit code
int collect_sweep(const fs::path& folder, const std::string& against,
                  const std::vector<std::string>& maps, std::size_t again) {
  const SweepView view = SweepView::of(SweepFolder::open(folder));
  refuse_rows_of_boards(view.sweep);
  std::optional<SweepView> before;
  if (!against.empty()) before = SweepView::of(SweepFolder::open(against));
  SweepPage page;
  page.before = before ? &*before : nullptr;
  for (const std::string& map : maps) page.maps.push_back(parse_map(map));
  const SweepCounts counts = view.counts();
  const std::vector<ShareCheck> checks = check_shares(view.sweep.study.limits, counts);
  constexpr std::size_t kWorst = 10;
  page.worst = worst_rows(view, std::max(kWorst, again));
  base::write_file(folder / "results.csv", view.sweep.results_csv(view.results));
  base::write_file(folder / "machine.csv", view.sweep.machine_csv_of(view.results));
  write_sqlite(view, folder / "sweep.sqlite");
  base::write_file(folder / "junit.xml", sweep_junit(view.sweep.study.name, counts, checks));
  page.flown_again = fly_again(
      view.sweep,
      {page.worst.begin(),
       page.worst.begin() + static_cast<std::ptrdiff_t>(std::min(again, page.worst.size()))},
      1);
  base::write_file(folder / "sweep.html", sweep_html(view, checks, page));
  fmt::print("{}Results: {}\n", sweep_text(view, checks, page.before), folder.string());
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

/// @return exit code @throws std::runtime_error when Slurm refuses the array
int submit(const SweepFolder& sweep, SlurmArray array) {
  if (array.missing.empty()) {
    fmt::print("All runs have been flown; 'hils sweep collect {}' is next.\n", sweep.path.string());
    return kExitPassed;
  }
  for (const std::string& text : {array.logs.string(), array.partition}) {
    if (text.find_first_of("\"\\%\n\r") != std::string::npos) {
      throw base::ConfigError("'" + text + "': a job array takes no \", \\, % or line break here");
    }
  }
  fs::create_directories(array.logs);
  const bool is_first = !fs::exists(chunks_file(sweep));
  if (is_first) base::write_file(chunks_file(sweep), fmt::format("{}\n", array.chunks));
  const fs::path script = sweep.path / "slurm" / "sweep.sbatch";
  base::write_file(script, slurm_script(array));
  fmt::print("{}: {} of {} chunks\n", script.string(), array.missing.size(), array.chunks);
  const fs::path sbatch = on_path("sbatch");
  if (sbatch.empty()) {
    throw std::runtime_error(
        fmt::format("there is no sbatch on this machine; sweep.sbatch was written for {} chunks, "
                    "where there is one: sbatch {}",
                    array.chunks, shell_word(script.string())));
  }
  const fs::path log_file = sweep.path / "slurm" / "sbatch.txt";
  ChildProcess process(
      {.name = "sbatch", .arguments = {sbatch.string(), script.string()}, .log_file = log_file});
  constexpr base::Duration kPatience = std::chrono::minutes(2);
  const std::optional<ExitStatus>& end = process.wait_exit(kPatience);
  const std::string said = text_of_file(log_file);
  if (!end || end->code != 0) {
    if (end && is_first) fs::remove(chunks_file(sweep));  // no job has these chunks
    throw std::runtime_error(
        fmt::format("sbatch {}: {}", end ? end->words : "does not answer", said));
  }
  fmt::print("{}", said);
  return kExitPassed;
}

}  // namespace

int SweepCommand::run() const {
  const SweepCommand::Flags& flags = *flags_;
  if (flags.fly->parsed()) return fly_row(flags.folder);
  if (flags.status->parsed()) {
    print_status(SweepFolder::open(flags.folder));
    return kExitPassed;
  }
  if (flags.show->parsed()) {
    print_row(SweepFolder::open(flags.folder), flags.row);
    return kExitPassed;
  }
  if (flags.collect->parsed()) {
    return collect_sweep(fs::absolute(flags.folder), flags.against, flags.maps, flags.again);
  }
  if (flags.run->parsed()) {
    const SweepFolder sweep = SweepFolder::open(flags.folder);
    if (flags.slurm) {
      const double seconds =
          flags.run_seconds > 0 ? flags.run_seconds : measured_run_seconds(sweep);
      const std::size_t rows = sweep.table.rows.size();
      const std::size_t chunks = chunks_of_array(
          sweep, flags.chunks, slurm_chunks(rows, seconds, flags.jobs, flags.chunk_minutes));
      const double chunk_s =
          seconds * std::ceil(static_cast<double>(rows) / static_cast<double>(chunks * flags.jobs));
      return submit(sweep, {.name = sweep.study.name,
                            .program = own_program(),
                            .sweep = sweep.path,
                            .logs = sweep.path / "slurm",
                            .chunks = chunks,
                            .missing = missing_chunks(sweep, chunks),
                            .jobs = flags.jobs,
                            // Four times what it takes, for slower nodes.
                            .minutes = static_cast<std::size_t>(std::ceil(chunk_s / 15)) + 5,
                            .partition = flags.partition});
    }
    return run_part(sweep,
                    {.chunk = Chunk::parse(flags.chunk),
                     .jobs = flags.jobs,
                     .scratch = flags.scratch.empty() ? fs::path() : fs::absolute(flags.scratch),
                     .retry = flags.retry});
  }
  if (flags.study.empty() || flags.folder.empty()) {
    throw base::ConfigError(
        "sweep takes STUDY.yaml and --out DIR, or one of plan, run, status, show and collect");
  }
  const fs::path study = base::find_config(flags.study);
  const SweepFolder sweep = SweepFolder::plan(study, flags.folder);
  fmt::print("{}: {} runs in {}\n", sweep.study.name, sweep.table.rows.size(),
             (sweep.path / "table.csv").string());
  if (flags.plan->parsed()) return kExitPassed;
  run_part(sweep, {.jobs = flags.jobs});
  return collect_sweep(sweep.path, flags.against, flags.maps, flags.again);
}

}  // namespace cas::hils
