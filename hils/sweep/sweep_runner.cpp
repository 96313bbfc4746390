// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <thread>
#include <vector>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/scratch_folder.hpp"
#include "hils/sweep/flight_pool.hpp"
#include "hils/sweep/journal.hpp"
#include "hils/sweep/sweep_progress.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

class Runner {
 public:
  Runner(const SweepFolder& sweep, const SweepRunOptions& options)
      : sweep_(sweep),
        options_(options),
        first_(rows_of_chunk(sweep.table.rows.size(), options.chunk.k, options.chunk.n).first),
        last_(rows_of_chunk(sweep.table.rows.size(), options.chunk.k, options.chunk.n).second),
        journal_(journal_folder(sweep.path) / (options.chunk.name() + ".jsonl")),
        scratch_(options.scratch.empty() ? sweep.path / "work"
                                         : fresh_folder(options.scratch, "hils-sweep")) {
    find_pending();
  }

  ~Runner() {
    pool_.reset();
    std::error_code ignored;
    fs::remove(scratch_, ignored);  // unless another chunk has its files there
  }
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  void fly() {
    // We hold the journal's lock, so files there belong to a killed runner.
    const fs::path& root = options_.scratch.empty() ? sweep_.path : scratch_;
    pool_.emplace(base::ResultPlace{root, scratch_ / options_.chunk.name()},
                  sweep_.study.deadline_s + options_.after_s,
                  options_.on_boards || options_.keeps_flights
                      ? std::vector<std::string>{"campaign", "--fly"}
                      : std::vector<std::string>{"sweep", "fly"});
    const StopRequest stop;
    while (next_ < pending_.size() || pool_->size() > 0) {
      while (next_ < pending_.size() && pool_->size() < options_.jobs) {
        pool_->start(RowTask::of(sweep_, pending_[next_++]));
      }
      pool_->wait();
      if (StopRequest::raised()) {
        progress_.clear();
        throw RunStopped(
            fmt::format("interrupted; {} of {} runs are done, 'hils sweep run' goes on with the "
                        "others",
                        state_.done, state_.all),
            true);
      }
      pool_->take_ended([this](RowResult&& result) { keep(result); });
      state_.elapsed = base::steady_now() - begin_;
      progress_.show(state_);
    }
    progress_.clear();
  }

  /// Writes the chunk's files.
  SweepRunResult finish() const {
    const std::vector<RowResult> results = sweep_.results(first_, last_);
    const fs::path csv = sweep_.chunk_csv(options_.chunk);
    base::write_result({sweep_.path, sweep_.machine_csv(options_.chunk)},
                       sweep_.machine_csv_of(results), base::Durability::kDisk);
    base::write_result({sweep_.path, csv}, sweep_.results_csv(results), base::Durability::kDisk);
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
  static fs::path journal_folder(const fs::path& sweep) {
    base::make_result_folder({sweep, "journal"});
    return sweep / "journal";
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
    state_.verb = options_.verb;
    state_.all = last_ - first_;
    state_.done = state_.all - pending_.size();
  }

  void keep(const RowResult& result) {
    journal_.append(result);
    ++state_.done;
    ++state_.flown;
    if (!is_judged(result.outcome)) ++state_.unjudged;
  }

  const SweepFolder& sweep_;
  const SweepRunOptions& options_;
  std::size_t first_;
  std::size_t last_;
  Journal journal_;
  fs::path scratch_;
  std::vector<std::size_t> pending_;
  std::size_t next_ = 0;
  std::optional<FlightPool> pool_;
  SweepState state_;
  SweepProgress progress_;
  base::RunTime begin_ = base::steady_now();
};

}  // namespace

std::size_t usual_jobs(const SweepFolder& sweep) {
  if (Scenario::load(sweep.scenario()).firmware) return 1;
  return std::max(1U, std::thread::hardware_concurrency());
}

void refuse_rows_of_boards(const SweepFolder& sweep) {
  if (!fs::exists(sweep.path / kControllersFile)) return;
  throw base::ConfigError(sweep.path.string() +
                          ": is flown with boards, by 'hils campaign CAMPAIGN --fcu BOARD'");
}

SweepRunResult run_sweep(const SweepFolder& sweep, const SweepRunOptions& options) {
  if (options.chunk.n > sweep.table.rows.size()) {
    throw base::ConfigError(fmt::format("the sweep has {} rows and cannot be cut into {} chunks",
                                        sweep.table.rows.size(), options.chunk.n));
  }
  if (!options.on_boards) refuse_rows_of_boards(sweep);
  Runner runner(sweep, options);
  runner.fly();
  return runner.finish();
}

}  // namespace cas::hils
