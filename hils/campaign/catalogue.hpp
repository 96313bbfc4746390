// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cas::hils {

/// A number that a failure takes.
struct FailureParameter {
  std::string_view name;  ///< with its unit
  double usual = 0;
  double least = 0;
  double most = 0;
};

/// Requirement of a failure that not every bench meets.
enum class FailureNeeds {
  kNothing,
  kPrograms,      ///< casd as a program, which the virtual clock has not
  kVirtualClock,  ///< the models of the virtual clock
  kLineModel,     ///< the emulated serial line: on the virtual clock, or an emulator's
};

/// One failure of the catalogue. It acts on physics or bytes; the vehicle's reaction is its own.
struct Failure {
  std::string_view name;
  std::string_view part{};   ///< of the vehicle or the bench: "GPS"
  std::string_view meaning;  ///< the real-world failure
  std::string_view physics;  ///< its effect in the simulation
  std::string_view source;   ///< where it is known from
  std::vector<FailureParameter> parameters{};
  /// Effects of a scenario's `faults`, YAML with $NAME for parameters. All strike together.
  std::vector<std::string_view> effects;
  bool of_bench = false;  ///< its conditions ask the truth by name, and it always has an end
  FailureNeeds needs = FailureNeeds::kNothing;
  bool unrecorded = false;  ///< it may act, and the record of the flight is the same
};

/// How long a failure lasts that a campaign gives no `for_s`: to the end of the run.
inline constexpr std::string_view kDuration = "for_s";

/// All failures, in the order in which they are listed.
const std::vector<Failure>& failure_catalogue();
/// @return nullptr when there is none of that name
const Failure* find_failure(std::string_view name);

/// Why a campaign cannot fly a failure: "needs casd as a program"; nullopt: it can.
/// @param on_board  in real time with a board, else on the virtual clock
std::optional<std::string_view> obstacle(const Failure& failure, bool on_board);

/// The entries of a scenario's `faults` for one failure, as a list in one line of YAML.
///
/// @param title   name of the entries
/// @param when    condition at which it strikes
/// @param values  of its parameters where they are not the usual ones, and `for_s`
std::string faults_of(const Failure& failure, const std::string& title, const std::string& when,
                      const std::map<std::string, double, std::less<>>& values);

/// The catalogue for a terminal, and as the table of docs/campaign.md.
std::string catalogue_text();
std::string catalogue_markdown();

}  // namespace cas::hils
