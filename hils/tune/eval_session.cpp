// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/eval_session.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/scratch_folder.hpp"
#include "hils/sweep/flight_pool.hpp"
#include "hils/tune/eval_line.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

/// Lines of a descriptor, which is read as far as it has something.
class InputLines {
 public:
  explicit InputLines(int fd) : fd_(fd) {}

  bool ended() const { return ended_; }
  /// Reads once; waits where there is nothing.
  void read() {
    std::string part(kPart, '\0');
    const ssize_t got = ::read(fd_, part.data(), part.size());
    if (got < 0 && errno == EINTR) return;
    if (got <= 0) {
      ended_ = true;
      if (!text_.empty()) text_ += '\n';  // a last line without its end
      return;
    }
    text_.append(part, 0, static_cast<std::size_t>(got));
    if (text_.size() > kLongest && text_.find('\n') == std::string::npos) {
      throw std::runtime_error("a line of more than 1 MiB is no request");
    }
  }
  std::optional<std::string> next() {
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
  }

 private:
  static constexpr std::size_t kPart = 1U << 16U;
  static constexpr std::size_t kLongest = 1U << 20U;

  int fd_;
  std::string text_;
  bool ended_ = false;
};

class EvalSession {
 public:
  EvalSession(const EvalOptions& options, fs::path folder)
      : options_(options),
        folder_(std::move(folder)),
        study_(Study::load(options.study)),
        study_folder_(fs::absolute(options.study).parent_path()) {
    const fs::path scenario = folder_ / "scenario";
    write_scenario(Study::scenario_of(options.study), study_.settings, study_folder_, scenario,
                   {"vehicle"});
    const Scenario loaded = Scenario::load(scenario / "scenario.yaml");
    seed_ = study_.seeds.empty() ? study_.row_seed.value_or(loaded.seed) : study_.seeds.front();
    figures_ = figure_names(loaded);
  }

  void describe() const { print(eval_description(study_, figures_)); }

  void run() {
    const StopRequest stop;
    ::signal(SIGPIPE, SIG_IGN);  // the failed write says it
    make_pool();
    while (true) {
      while (waiting_.size() < options_.jobs) {
        const std::optional<std::string> line = input_.next();
        if (!line) break;
        take(*line);
      }
      if (waiting_.empty() && input_.ended()) return;
      const bool reads = !input_.ended() && waiting_.size() < options_.jobs;
      if (pool_->wait(reads ? STDIN_FILENO : -1)) input_.read();
      if (StopRequest::raised()) throw RunStopped("interrupted", true);
      answer();
    }
  }

 private:
  static void print(const std::string& line) {
    if (std::fwrite(line.data(), 1, line.size(), stdout) != line.size() ||
        std::fflush(stdout) != 0) {
      throw std::runtime_error("standard output is closed: no program reads the answers");
    }
  }

  void make_pool() {
    pool_.reset();
    pool_ = std::make_unique<FlightPool>(base::ResultPlace{folder_, "work"}, study_.deadline_s);
  }

  void take(const std::string& line) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) return;
    EvalRequest request = EvalRequest::parse(line, study_.parameters, seed_);
    if (request.error) return print(eval_error(request, *request.error));
    ++row_;
    try {
      pool_->start(task_of(request));
    } catch (const base::ConfigError& error) {
      return print(eval_error(request, error.what()));
    }
    waiting_.emplace(row_, std::move(request));
  }

  RowTask task_of(const EvalRequest& request) const {
    RowTask task{.row = row_,
                 .seed = request.seed,
                 .architecture = study_.architecture,
                 .scenario = folder_ / "scenario" / "scenario.yaml",
                 .study_folder = study_folder_,
                 .figures = figures_};
    for (const auto& [name, value] : request.parameters) {
      const auto parameter = std::ranges::find(study_.parameters, name, &Parameter::name);
      for (const std::string& key : parameter->keys) task.values.emplace_back(key, value);
    }
    return task;
  }

  void answer() {
    try {
      pool_->take_ended([this](RowResult&& result) {
        const auto request = waiting_.find(result.row);
        print(eval_answer(request->second, result, figures_));
        waiting_.erase(request);
      });
    } catch (const base::ConfigError& error) {  // the machine has let the runs down
      for (const auto& [row, request] : waiting_) print(eval_error(request, error.what()));
      waiting_.clear();
      make_pool();
    }
  }

  const EvalOptions& options_;
  fs::path folder_;
  Study study_;
  fs::path study_folder_;
  std::uint64_t seed_ = 1;  ///< where a request has none
  std::vector<std::string> figures_{};
  InputLines input_{STDIN_FILENO};
  std::unique_ptr<FlightPool> pool_{};
  std::map<std::size_t, EvalRequest> waiting_{};  ///< by the row of its flight
  std::size_t row_ = 0;
};

}  // namespace

int eval_lines(const EvalOptions& options) {
  const ScratchFolder folder(options.scratch, "hils-eval");
  EvalSession session(options, folder.path());
  if (options.describe) {
    session.describe();
  } else {
    session.run();
  }
  return kExitPassed;
}

}  // namespace cas::hils
