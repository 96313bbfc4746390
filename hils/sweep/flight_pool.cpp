// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/flight_pool.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

/// A shell's exit code for SIGTERM, which a job's end sends to all of its processes.
constexpr int kExitTerminated = 128 + SIGTERM;

volatile sig_atomic_t stop_raised = 0;

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "?";
  return name.data();
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

}  // namespace

FlightPool::FlightPool(const base::ResultPlace& folder, double deadline_s,
                       std::vector<std::string> flown_by)
    : place_(folder), deadline_s_(deadline_s), flown_by_(std::move(flown_by)), host_(host_name()) {
  constexpr int kTries = 10;  // another runner may remove the parent at its end
  for (int i = 1;; ++i) {
    try {
      base::remove_result_folder(folder);  // of a killed runner
      base::make_result_folder(folder);
      return;
    } catch (const base::ConfigError&) {
      if (i == kTries) throw;
    }
  }
}

FlightPool::~FlightPool() {
  flights_.clear();
  clear(place_);
}

/// What stays there does no harm.
void FlightPool::clear(const base::ResultPlace& folder) {
  try {
    base::remove_result_folder(folder);
  } catch (const base::ConfigError&) {
  }
}

void FlightPool::start(const RowTask& task) {
  const fs::path folder = place_.path() / std::to_string(task.row);
  base::make_result_folder({place_.out, folder});
  task.save(folder / "task.json");
  std::vector<std::string> arguments{kSameProgram};
  arguments.insert(arguments.end(), flown_by_.begin(), flown_by_.end());
  arguments.push_back(folder.string());
  ChildProcess::Options options{.name = "the process of a run",
                                .arguments = std::move(arguments),
                                .log_file = folder / "log.txt"};
  flights_.push_back({.row = task.row,
                      .folder = folder,
                      .process = std::make_unique<ChildProcess>(std::move(options))});
}

bool FlightPool::wait(int input) const {
  std::vector<pollfd> ends;
  for (const Flight& flight : flights_) ends.push_back({flight.process->pidfd(), POLLIN, 0});
  ends.push_back({input, POLLIN, 0});
  constexpr int kLookMs = 200;
  return ::poll(ends.data(), ends.size(), kLookMs) > 0 && ends.back().revents != 0;
}

void FlightPool::take_ended(const std::function<void(RowResult&&)>& take) {
  for (auto flight = flights_.begin(); flight != flights_.end();) {
    const base::Duration elapsed = base::steady_now() - flight->process->begin();
    RowResult result;
    ExitStatus end;
    if (const auto& exit = flight->process->poll_exit()) {
      end = *exit;
      result = result_of(*flight, end);
    } else if (base::to_seconds(elapsed) > deadline_s_) {
      flight->process->kill();
      result = written_result(*flight).value_or(row_without_figures(
          RowOutcome::kHung, fmt::format("the run had no result after {:g} s", deadline_s_)));
    } else {
      ++flight;
      continue;
    }
    result.row = flight->row;
    result.version = CAS_VERSION;
    result.machine = {.wall_s = base::to_seconds(elapsed),
                      .cpu_s = end.cpu_s,
                      .max_rss_mib = end.max_rss_mib,
                      .host = host_};
    take(std::move(result));
    clear({place_.out, flight->folder});
    flight = flights_.erase(flight);
  }
}

RowResult FlightPool::result_of(const Flight& flight, const ExitStatus& end) const {
  const fs::path log_file = flight.folder / "log.txt";
  if (end.code == kExitMachine) {
    throw base::ConfigError(
        fmt::format("row {}{}; what has been flown is kept", flight.row, tail_of(log_file)));
  }
  if (end.code == kExitInterrupted || end.code == kExitTerminated) {
    throw RunStopped(
        fmt::format("row {} was interrupted; the same command goes on with it", flight.row), true);
  }
  if (end.code >= kExitBoardAbsent && end.code <= kExitBoardBusy) {
    throw BoardError(static_cast<ExitCode>(end.code), text_of_file(flight.folder / kBoardSentence));
  }
  if (end.code == kExitPassed) {
    if (auto result = written_result(flight)) return std::move(*result);
  }
  return row_without_figures(RowOutcome::kDied,
                             "the process of the run " + end.words + tail_of(log_file));
}

/// Nothing where it has left none.
std::optional<RowResult> FlightPool::written_result(const Flight& flight) {
  try {
    auto result = parse_journal_line(text_of_file(flight.folder / "result.json"));
    if (result && result->row == flight.row) return result;
  } catch (const base::ConfigError&) {
    // it is not there
  }
  return std::nullopt;
}

struct StopRequest::Actions {
  struct sigaction on_int {};
  struct sigaction on_term {};
};

StopRequest::StopRequest() : before_(std::make_unique<Actions>()) {
  stop_raised = 0;
  struct sigaction action {};
  action.sa_handler = [](int) { stop_raised = 1; };
  ::sigaction(SIGINT, &action, &before_->on_int);
  ::sigaction(SIGTERM, &action, &before_->on_term);
}

StopRequest::~StopRequest() {
  ::sigaction(SIGINT, &before_->on_int, nullptr);
  ::sigaction(SIGTERM, &before_->on_term, nullptr);
}

bool StopRequest::raised() { return stop_raised != 0; }

}  // namespace cas::hils
