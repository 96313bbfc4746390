// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_flights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <sstream>
#include <utility>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/run/scratch_folder.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

constexpr const char* kJournal = "journal/flights.jsonl";

/// The figures' names as eight digits (FNV-1a).
std::string hash_of(const std::vector<std::string>& names) {
  std::uint32_t hash = 2'166'136'261U;
  for (const std::string& name : names) {
    for (const char c : name + ',') {
      hash = (hash ^ static_cast<unsigned char>(c)) * 16'777'619U;
    }
  }
  return fmt::format("{:08x}", hash);
}

/// Whether a folder has more than `journal` and `scenarios`, which a tuning leaves if it ends
/// before it has its study.yaml.
bool is_foreign(const fs::path& folder) {
  if (!fs::is_directory(folder)) return false;
  return std::ranges::any_of(fs::directory_iterator(folder), [](const auto& entry) {
    const fs::path name = entry.path().filename();
    return name != "journal" && name != "scenarios";
  });
}

}  // namespace

TuneFlights::TuneFlights(const TuneStudy& study, const fs::path& study_file, const fs::path& folder,
                         std::size_t jobs)
    : study_(study),
      folder_(fs::absolute(folder)),
      study_folder_(fs::absolute(study_file).parent_path()),
      jobs_(jobs),
      scenarios_(study.scenarios) {
  scenarios_.insert(scenarios_.end(), study.verify_scenarios.begin(), study.verify_scenarios.end());
  prepare(study_file);
  journal_.emplace(folder_ / kJournal);
  load_journal();
}

TuneFlights::~TuneFlights() { progress_.clear(); }

void TuneFlights::prepare(const fs::path& study_file) {
  const fs::path frozen = folder_ / "study.yaml";
  const std::string text = text_of_file(study_file);
  if (fs::exists(frozen) ? text_of_file(frozen) != text : fs::exists(folder_ / "plan.json")) {
    throw base::ConfigError(folder_.string() +
                            ": holds another study, or this one before it was changed; its flights "
                            "stay as they are: choose another folder");
  }
  std::error_code none;
  if (fs::equivalent(folder_, study_folder_, none)) {
    throw base::ConfigError(folder_.string() + ": holds the study itself: choose another folder");
  }
  if (!fs::exists(frozen) && is_foreign(folder_)) {
    throw base::ConfigError(folder_.string() +
                            ": is not empty and holds no tuning: choose another folder");
  }
  make_results_folder(folder_);
  base::make_result_folder({folder_, "journal"});
  for (std::size_t i = 0; i < scenarios_.size(); ++i) {
    const TuneScenario& own = scenarios_[i];
    if (!fs::exists(frozen)) {
      base::make_result_folder({folder_, scenario(i).parent_path()});
      write_scenario(own.scenario, own.settings, study_folder_, scenario(i).parent_path(),
                     {"vehicle"});
    }
    const ScratchFolder scratch(fs::temp_directory_path(), "hils-tune");
    const fs::path& trial = scratch.path();
    try {
      write_scenario(scenario(i), study_.values_of(study_.before()), study_folder_, trial);
      figures_.push_back(figure_names(Scenario::load(trial / "scenario.yaml")));
    } catch (const base::ConfigError& error) {
      throw base::ConfigError("scenario '" + own.name +
                              "': " + without_folder(error.what(), trial));
    }
  }
  base::write_result({folder_, frozen}, text, base::Durability::kDisk);
}

void TuneFlights::load_journal() {
  std::istringstream lines(text_of_file(folder_ / kJournal));
  for (std::string line; std::getline(lines, line);) {
    std::optional<RowResult> result = parse_journal_line(line);
    // Broken runs, too: an interrupted search asks for the same flights in the same order.
    if (!result || result->key.empty()) continue;
    results_.insert_or_assign(result->key, std::move(*result));
  }
}

fs::path TuneFlights::scenario(std::size_t index) const {
  return folder_ / "scenarios" / scenarios_[index].name / "scenario.yaml";
}

bool TuneFlights::has_figure(std::size_t scenario, const std::string& name) const {
  if (name == kDelayMargin) return scenarios_[scenario].delay_ramp.has_value();
  return std::ranges::find(figures_[scenario], name) != figures_[scenario].end();
}

std::string TuneFlights::key_of(const TuneFlight& flight) const {
  std::string key = fmt::format("{} seed {}:", scenarios_[flight.scenario].name, flight.seed);
  for (const std::string& value : flight.values) key += " " + value;
  return key + " " + hash_of(figures_[flight.scenario]);
}

RowTask TuneFlights::task_of(const TuneFlight& flight, std::size_t row) const {
  return {.row = row,
          .seed = flight.seed,
          .architecture = study_.architecture,
          .scenario = scenario(flight.scenario),
          .study_folder = study_folder_,
          .values = study_.values_of(flight.values),
          .figures = figures_[flight.scenario]};
}

std::vector<RowResult> TuneFlights::fly(const std::vector<TuneFlight>& flights) {
  std::vector<std::string> keys;
  std::map<std::size_t, std::string> keys_of_rows;
  std::deque<RowTask> pending;
  for (const TuneFlight& flight : flights) {
    const std::string& key = keys.emplace_back(key_of(flight));
    const bool asked = std::find(keys.begin(), keys.end() - 1, key) != keys.end() - 1;
    if (asked || results_.contains(key)) continue;
    const std::size_t row = results_.size() + pending.size() + 1;
    keys_of_rows[row] = key;
    pending.push_back(task_of(flight, row));
  }
  FlightPool pool({folder_, "work"}, study_.deadline_s);
  const StopRequest stop;
  while (!pending.empty() || pool.size() > 0) {
    for (; !pending.empty() && pool.size() < jobs_; pending.pop_front()) {
      pool.start(pending.front());
    }
    pool.wait();
    if (StopRequest::raised()) {
      progress_.clear();
      throw RunStopped("interrupted; the same command goes on with what has not been flown", true);
    }
    pool.take_ended([&](RowResult&& result) {
      result.key = keys_of_rows.at(result.row);
      journal_->append(result);
      ++state_.flown;
      results_.insert_or_assign(result.key, std::move(result));
    });
    state_.done = results_.size();
    state_.all = std::max(state_.all, state_.done);
    state_.elapsed = base::steady_now() - begin_;
    progress_.show(state_);
  }
  std::vector<RowResult> results;
  results.reserve(keys.size());
  for (const std::string& key : keys) results.push_back(results_.at(key));
  return results;
}

FlightWarnings TuneFlights::warnings() const {
  FlightWarnings warnings;
  for (const auto& [key, result] : results_) warnings.add(result.warnings);
  return warnings;
}

double TuneFlights::figure(std::size_t scenario, const RowResult& result,
                           const std::string& name) const {
  const auto value = [&](std::size_t index) {
    return index < result.figures.size() ? result.figures[index]
                                         : std::numeric_limits<double>::quiet_NaN();
  };
  if (name != kDelayMargin) {
    const auto found = std::ranges::find(figures_[scenario], name);
    return value(static_cast<std::size_t>(found - figures_[scenario].begin()));
  }
  const double crash_s = value(kCrashFigure);
  const double end_s = std::isfinite(crash_s) ? crash_s : value(kSimulatedFigure);
  return std::isfinite(end_s) ? scenarios_[scenario].delay_ramp->margin_us(end_s) : end_s;
}

}  // namespace cas::hils
