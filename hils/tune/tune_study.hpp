// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hils/sweep/key_path.hpp"
#include "hils/sweep/study.hpp"
#include "hils/tune/delay_ramp.hpp"
#include "hils/tune/tune_search.hpp"

namespace cas::hils {

/// Figure of a scenario with a delay ramp, besides those of a sweep's table.
inline constexpr std::string_view kDelayMargin = "delay_margin_us";

/// A scenario that each candidate flies.
struct TuneScenario {
  std::string name;
  std::filesystem::path scenario;
  std::vector<KeyValue> settings{};       ///< `set`: keys that differ from the file
  std::optional<DelayRamp> delay_ramp{};  ///< then an incident is the end of the measurement
};

/// A number that is searched.
struct TuneParameter {
  Parameter parameter;  ///< uniform or log
  double from = 0;      ///< its value before

  /// Value at a place of the unit interval, as the scenario gets it: four digits, or whole.
  std::string value_at(double u) const;
  /// The place of `from`.
  double place() const;
};

/// A figure over some scenarios. For each scenario: the mean over the seeds, of several figures the
/// root of the sum of their squares. Then the worst of the scenarios.
struct TuneFigure {
  std::string name;
  std::vector<std::string> figures;
  std::vector<std::size_t> in;  ///< indices of the scenarios
};

/// Figure to minimise.
struct Objective {
  TuneFigure figure;
  double weight =
      1;  ///< in the sum by which one candidate is chosen, of shares of the value before
};

/// Constraint on a figure. Exactly one bound; `before` is the value before the tuning.
struct Guard {
  TuneFigure figure;
  bool at_least = true;           ///< else at most
  std::optional<double> bound{};  ///< nullopt: the value before
};

/// Contents of a study of `hils tune` (config/studies/tune_*.yaml). Keys are the members' names.
struct TuneStudy {
  std::string name;
  std::string description;
  Architecture architecture = Architecture::kDirect;
  std::vector<TuneScenario> scenarios;
  std::vector<std::uint64_t> seeds;
  std::vector<TuneParameter> vary;
  std::vector<Objective> objectives;
  std::vector<Guard> guards;
  SearchMethod method = SearchMethod::kNsga2;
  std::size_t population = 16;
  std::size_t generations = 10;
  std::uint64_t seed = 1;  ///< of the search
  std::vector<TuneScenario> verify_scenarios;
  std::vector<std::uint64_t> verify_seeds;
  double deadline_s = 300;

  /// @throws base::ConfigError with file, line and key path
  static TuneStudy load(const std::filesystem::path& file);
  /// Key path and value of each parameter of a candidate.
  std::vector<KeyValue> values_of(const std::vector<std::string>& candidate) const;
  /// The candidate before tuning.
  std::vector<std::string> before() const;
};

}  // namespace cas::hils
