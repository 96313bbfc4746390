// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// How a number of a study is spread.
struct Distribution {
  enum class Kind {
    kUniform,  ///< between least and most
    kLog,      ///< its logarithm is uniform between those of least and most
    kNormal,   ///< mean and deviation, cut off at least and most where they are given
  };
  Kind kind = Kind::kUniform;
  double mean = 0;
  double deviation = 0;
  std::optional<double> least{};
  std::optional<double> most{};

  /// The value below which the share `u` lies. @param u  in (0, 1)
  double quantile(double u) const;
};

/// One thing that a study varies.
struct Parameter {
  std::string name{};                 ///< column of the table; the first key where none is given
  std::vector<std::string> keys{};    ///< key paths of the scenario, see KeyStep; all get the value
  std::vector<std::string> values{};  ///< of a list or a range; empty: it has a distribution
  std::optional<Distribution> distribution{};
  bool whole = false;  ///< drawn values are rounded to whole numbers
};

/// How the points of all parameters with a distribution are chosen.
enum class Sampling {
  kNone,            ///< no parameter has a distribution
  kRandom,          ///< independent draws
  kLatinHypercube,  ///< each parameter has one point in each of as many equal shares as points
  kSobol,           ///< Sobol's sequence with the direction numbers of [Joe-Kuo]
};

/// Which share of the runs a limit of a study is about.
enum class Share {
  kUp,      ///< flown to the end without an incident
  kPassed,  ///< passed all limits of the scenario
  kJudged,  ///< has a verdict: the run itself neither died nor hung nor was refused
};
std::string_view to_string(Share share);

/// A share of the runs that must be reached: its lower Clopper-Pearson bound, one-sided at
/// `confidence`, is at least `at_least`. A run without a verdict does not count for it.
struct ShareLimit {
  Share share = Share::kUp;
  double at_least = 1;
  double confidence = 0.95;
};

/// Contents of a study file (config/studies/*.yaml). Keys are the members' names.
struct Study {
  std::string name;
  std::string description;
  std::string scenario;  ///< file, from the study's folder or shipped
  Architecture architecture = Architecture::kDirect;
  Sampling sampling = Sampling::kNone;
  std::size_t points = 0;                 ///< of the parameters with a distribution
  std::uint64_t seed = 1;                 ///< of the table
  std::vector<std::uint64_t> seeds{};     ///< each point is flown with each; empty: the scenario's
  std::optional<std::uint64_t> row_seed;  ///< instead: of row 1; row 2 has the next one
  double deadline_s = 300;                ///< wall-clock time after which a run has hung
  std::vector<Parameter> parameters{};
  std::vector<std::pair<std::string, std::string>> settings{};  ///< key path, YAML; for all runs
  std::vector<ShareLimit> limits{};

  /// Reads and checks a study file; the scenario is not opened.
  /// @throws base::ConfigError with file, line and key path
  static Study load(const std::filesystem::path& file);
  /// The scenario of a study file. @throws base::ConfigError when it is nowhere
  static std::filesystem::path scenario_of(const std::filesystem::path& study_file);
};

/// Letters, digits and _ . - [ ]: a valid name of a column, scenario or folder.
bool is_plain_name(std::string_view name);
/// What studies of `hils sweep` and `hils tune` and campaigns have in common: `schema`, `name` (the
/// file's where none is given), `description`, `architecture`, `deadline_s`.
/// @throws base::ConfigError
template <class Study>
void read_head(const base::ConfigNode& root, const std::filesystem::path& file, Study& study) {
  if (root.require<int>("schema") != 1) root.at("schema").fail("this program reads schema 1");
  study.name = root.get<std::string>("name", file.stem().string());
  study.description = root.get<std::string>("description", "");
  try {
    study.architecture = parse_architecture(root.get<std::string>("architecture", "direct"));
  } catch (const base::ConfigError& error) {
    root.at("architecture").fail(error.what());
  }
  study.deadline_s = root.get_in("deadline_s", study.deadline_s, 1, 1e6);
}
/// The list `vary`. @throws base::ConfigError
std::vector<Parameter> parse_parameters(const base::ConfigNode& root);
/// The map `set`: key paths and the YAML of their values. @throws base::ConfigError
std::vector<std::pair<std::string, std::string>> parse_settings(const base::ConfigNode& root);
/// A list of seeds, or {first, count}. @throws base::ConfigError
std::vector<std::uint64_t> parse_seed_list(const base::ConfigNode& node);

}  // namespace cas::hils
