// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hils/sweep/flight_pool.hpp"
#include "hils/sweep/journal.hpp"
#include "hils/sweep/row_result.hpp"
#include "hils/sweep/sweep_progress.hpp"
#include "hils/tune/tune_study.hpp"

namespace cas::hils {

/// One flight of a candidate.
struct TuneFlight {
  std::size_t scenario = 0;  ///< index among TuneFlights::scenarios()
  std::uint64_t seed = 1;
  std::vector<std::string> values{};
};

/// The folder of a tuning and its flights. Each is flown once: a line of the journal names its
/// flight, and after any end counts for that one alone.
///
///   study.yaml               frozen when it began
///   scenarios/NAME/          scenario.yaml with the study's `set`, and its vehicle
///   journal/flights.jsonl    a line for each flight, on the disk before the next
class TuneFlights {
 public:
  /// @throws base::ConfigError also when the folder holds another study or anything else, and when
  /// a scenario does not take the values before
  TuneFlights(const TuneStudy& study, const std::filesystem::path& study_file,
              const std::filesystem::path& folder, std::size_t jobs);
  ~TuneFlights();
  TuneFlights(const TuneFlights&) = delete;
  TuneFlights& operator=(const TuneFlights&) = delete;

  /// The scenarios of the search, then those of the verification.
  const std::vector<TuneScenario>& scenarios() const { return scenarios_; }
  std::filesystem::path scenario(std::size_t index) const;
  bool has_figure(std::size_t scenario, const std::string& name) const;

  /// Flies those of the flights that are new, several at once. @return results in the order of the
  /// flights
  /// @throws RunStopped, base::ConfigError
  std::vector<RowResult> fly(const std::vector<TuneFlight>& flights);
  /// A figure of a flight; not a number where it has none.
  double figure(std::size_t scenario, const RowResult& result, const std::string& name) const;

  /// Warnings of all flights so far.
  FlightWarnings warnings() const;

  /// How many flights there will be about, for the progress.
  void expect(std::size_t flights) { state_.all = flights; }

 private:
  void prepare(const std::filesystem::path& study_file);
  void load_journal();
  /// Scenario, seed, values and the names of the figures: flights with one key are the same.
  std::string key_of(const TuneFlight& flight) const;
  RowTask task_of(const TuneFlight& flight, std::size_t row) const;

  const TuneStudy& study_;
  std::filesystem::path folder_;
  std::filesystem::path study_folder_;
  std::size_t jobs_;
  std::vector<TuneScenario> scenarios_;
  std::vector<std::vector<std::string>> figures_{};  ///< columns of each scenario
  std::map<std::string, RowResult> results_{};       ///< by their keys
  std::optional<Journal> journal_{};                 ///< opened when the folder is there
  SweepState state_{.verb = "tune"};
  SweepProgress progress_{};
  base::RunTime begin_ = base::steady_now();
};

}  // namespace cas::hils
