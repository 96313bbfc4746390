// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_runner.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <list>
#include <memory>
#include <vector>

#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/programs/child_process.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/sweep/journal.hpp"
#include "hils/sweep/row_flight.hpp"
#include "hils/sweep/sweep_progress.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

/// Notes SIGINT and SIGTERM while it lives.
class StopRequest {
 public:
  StopRequest() {
    raised_ = 0;
    struct sigaction action {};
    action.sa_handler = [](int) { raised_ = 1; };
    ::sigaction(SIGINT, &action, &before_int_);
    ::sigaction(SIGTERM, &action, &before_term_);
  }
  ~StopRequest() {
    ::sigaction(SIGINT, &before_int_, nullptr);
    ::sigaction(SIGTERM, &before_term_, nullptr);
  }
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;
  static bool raised() { return raised_ != 0; }

 private:
  static inline volatile sig_atomic_t raised_ = 0;
  struct sigaction before_int_ {};
  struct sigaction before_term_ {};
};

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "?";
  return name.data();
}

/// A new folder whose name nobody knows before: others may write where it is made.
fs::path fresh_folder(const fs::path& parent) {
  std::error_code exists;
  fs::create_directories(parent, exists);
  std::string name = (parent / "hils-sweep-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw base::ConfigError(name + ": cannot be made: " + std::strerror(errno));
  }
  return name;
}

/// The last lines of a program's output, on one line.
std::string tail_of(const fs::path& log_file) {
  constexpr std::size_t kMost = 300;
  std::string text;
  try {
    text = text_of_file(log_file);
  } catch (const base::ConfigError&) {
    return {};
  }
  while (text.ends_with('\n')) text.pop_back();
  if (text.size() > kMost) text.erase(0, text.size() - kMost);
  std::ranges::replace(text, '\n', ' ');
  return text.empty() ? text : ": " + text;
}

/// As a shell tells it: ended by SIGTERM, which a job's end sends to all of its processes.
constexpr int kExitTerminated = 128 + SIGTERM;

/// A run under way.
struct Flight {
  std::size_t row;
  fs::path folder;
  std::unique_ptr<ChildProcess> process;
};

class Runner {
 public:
  Runner(const SweepFolder& sweep, const SweepRunOptions& options)
      : sweep_(sweep),
        options_(options),
        first_(rows_of_chunk(sweep.table.rows.size(), options.chunk.k, options.chunk.n).first),
        last_(rows_of_chunk(sweep.table.rows.size(), options.chunk.k, options.chunk.n).second),
        scratch_((options.scratch.empty() ? sweep.path / "work" : fresh_folder(options.scratch)) /
                 options.chunk.name()),
        journal_(make_folder(sweep.path / "journal") / (options.chunk.name() + ".jsonl")),
        host_(host_name()) {
    fs::remove_all(scratch_);  // of a runner that was killed: the journal's lock shows that it is
    std::error_code error;     // a chunk that ends may take the folder above away meanwhile
    for (int i = 0; i < 10; ++i) {
      fs::create_directories(scratch_, error);
      if (!error) break;
    }
    if (error) throw base::ConfigError(scratch_.string() + ": cannot be made: " + error.message());
    find_pending();
  }

  ~Runner() {
    flights_.clear();
    std::error_code ignored;
    fs::remove_all(scratch_, ignored);
    fs::remove(scratch_.parent_path(), ignored);  // unless another chunk has its files there
  }
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  void fly() {
    const StopRequest stop;
    while (next_ < pending_.size() || !flights_.empty()) {
      while (next_ < pending_.size() && flights_.size() < options_.jobs) start(pending_[next_++]);
      wait();
      if (StopRequest::raised()) {
        progress_.clear();
        throw RunStopped(
            fmt::format("interrupted; {} of {} runs are done, 'hils sweep run' goes on with the "
                        "others",
                        state_.done, state_.all),
            true);
      }
      collect();
      state_.elapsed = base::steady_now() - begin_;
      progress_.show(state_);
    }
    progress_.clear();
  }

  /// Writes the chunk's files.
  SweepRunResult finish() const {
    const std::vector<RowResult> results = sweep_.results(first_, last_);
    const fs::path csv = sweep_.chunk_csv(options_.chunk);
    fs::create_directories(csv.parent_path());
    base::write_file(sweep_.machine_csv(options_.chunk), sweep_.machine_csv_of(results));
    base::write_file(csv, sweep_.results_csv(results));
    SweepRunResult summary{.rows = results.size(), .flown = state_.flown};
    std::size_t refused = 0;
    for (const RowResult& result : results) {
      if (is_judged(result.outcome)) continue;
      ++summary.unjudged;
      if (result.outcome == RowOutcome::kRefused) ++refused;
      if (summary.first_cause.empty()) {
        summary.first_cause =
            fmt::format("row {} {}: {}", result.row, to_string(result.outcome), result.cause);
      }
    }
    summary.all_refused = !results.empty() && refused == results.size();
    return summary;
  }

 private:
  static fs::path make_folder(const fs::path& folder) {
    fs::create_directories(folder);
    return folder;
  }

  void find_pending() {
    std::vector<bool> done(last_ - first_, false);
    sweep_.for_each_result([&](RowResult&& result) {
      if (result.row < first_ || result.row >= last_) return;
      if (!(options_.retry && is_broken(result.outcome))) done[result.row - first_] = true;
    });
    for (std::size_t row = first_; row < last_; ++row) {
      if (!done[row - first_]) pending_.push_back(row);
    }
    state_.all = last_ - first_;
    state_.done = state_.all - pending_.size();
  }

  void start(std::size_t row) {
    const fs::path folder = scratch_ / std::to_string(row);
    fs::create_directories(folder);
    RowTask::of(sweep_, row).save(folder / "task.json");
    ChildProcess::Options options{.name = "the process of a run",
                                  .arguments = {kSameProgram, "sweep", "fly", folder.string()},
                                  .log_file = folder / "log.txt"};
    flights_.push_back({.row = row,
                        .folder = folder,
                        .process = std::make_unique<ChildProcess>(std::move(options))});
  }

  /// Until a process has ended or the next deadline may be over.
  void wait() {
    std::vector<pollfd> ends;
    for (const Flight& flight : flights_) ends.push_back({flight.process->pidfd(), POLLIN, 0});
    constexpr int kLookMs = 200;
    ::poll(ends.data(), ends.size(), kLookMs);
  }

  void collect() {
    for (auto flight = flights_.begin(); flight != flights_.end();) {
      const base::Duration elapsed = base::steady_now() - flight->process->begin();
      if (const auto& end = flight->process->poll_exit()) {
        keep(*flight, result_of(*flight, *end), *end, elapsed);
      } else if (base::to_seconds(elapsed) > sweep_.study.deadline_s) {
        flight->process->kill();
        keep(
            *flight,
            row_without_figures(RowOutcome::kHung, fmt::format("the run had no result after {:g} s",
                                                               sweep_.study.deadline_s)),
            {}, elapsed);
      } else {
        ++flight;
        continue;
      }
      std::error_code ignored;
      fs::remove_all(flight->folder, ignored);
      flight = flights_.erase(flight);
    }
  }

  RowResult result_of(const Flight& flight, const ExitStatus& end) const {
    const fs::path log_file = flight.folder / "log.txt";
    if (end.code == kExitMachine) {
      throw base::ConfigError("row " + std::to_string(flight.row) + tail_of(log_file) +
                              "; what has been flown is kept");
    }
    if (end.code == kExitInterrupted || end.code == kExitTerminated) {
      throw RunStopped(
          fmt::format("row {} was interrupted; 'hils sweep run' goes on with it", flight.row),
          true);
    }
    if (end.code == kExitPassed) {
      try {
        const std::string line = text_of_file(flight.folder / "result.json");
        if (auto result = parse_journal_line(line); result && result->row == flight.row) {
          return std::move(*result);
        }
      } catch (const base::ConfigError&) {
        // it ended without a result
      }
    }
    return row_without_figures(RowOutcome::kDied,
                               "the process of the run " + end.words + tail_of(log_file));
  }

  void keep(const Flight& flight, RowResult result, const ExitStatus& end, base::Duration elapsed) {
    result.row = flight.row;
    result.version = CAS_VERSION;
    result.machine = {.wall_s = base::to_seconds(elapsed),
                      .cpu_s = end.cpu_s,
                      .max_rss_mib = end.max_rss_mib,
                      .host = host_};
    journal_.append(result);
    ++state_.done;
    ++state_.flown;
    if (!is_judged(result.outcome)) ++state_.unjudged;
  }

  const SweepFolder& sweep_;
  const SweepRunOptions& options_;
  std::size_t first_;
  std::size_t last_;
  fs::path scratch_;
  Journal journal_;
  std::string host_;
  std::vector<std::size_t> pending_;
  std::size_t next_ = 0;
  std::list<Flight> flights_;
  SweepState state_;
  SweepProgress progress_;
  base::RunTime begin_ = base::steady_now();
};

}  // namespace

SweepRunResult run_sweep(const SweepFolder& sweep, const SweepRunOptions& options) {
  if (options.chunk.n > sweep.table.rows.size()) {
    throw base::ConfigError(fmt::format("the sweep has {} rows and cannot be cut into {} chunks",
                                        sweep.table.rows.size(), options.chunk.n));
  }
  Runner runner(sweep, options);
  runner.fly();
  return runner.finish();
}

}  // namespace cas::hils
