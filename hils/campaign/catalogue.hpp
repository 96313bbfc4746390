// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cas::base {
class ConfigNode;
}

namespace cas::hils {

/// @throws base::ConfigError at the node where the name of a failure, a parameter or a phase has
/// characters that a file or a table cannot have
void check_name(const base::ConfigNode& node, const std::string& name);

/// A number that a failure takes.
struct FailureParameter {
  std::string name;  ///< with its unit
  double usual = 0;
  double least = 0;
  double most = 0;
};

/// Requirement of a failure that not every bench meets.
enum class FailureNeeds {
  kNothing,
  kPrograms,      ///< casd as a program, which the virtual clock has not
  kVirtualClock,  ///< the models of the virtual clock
  kLineModel,     ///< the serial line of the virtual clock
};

/// One failure of the catalogue. It acts on physics or bytes; the vehicle's reaction is its own.
struct Failure {
  std::string name;
  std::string part;     ///< of the vehicle or the bench: "GPS"
  std::string meaning;  ///< the real-world failure
  std::string physics;  ///< its effect in the simulation
  std::string source;   ///< where it is known from
  std::vector<FailureParameter> parameters;
  /// Effects of a scenario's `faults`, YAML with $NAME for parameters. All strike together.
  std::vector<std::string> effects;
  bool of_bench = false;  ///< its conditions ask the truth by name, and it always has an end
  FailureNeeds needs = FailureNeeds::kNothing;
  bool unrecorded = false;  ///< it may act, and the record of the flight is the same
};

/// Parameter of every failure: how long it lasts, s. Without it to the end of the run, or 5 s where
/// the bench fails.
inline constexpr std::string_view kDuration = "for_s";

/// Failures by name, in the order of their files.
class FailureCatalogue {
 public:
  /// The failures of the shipped config/failures.yaml. @throws base::ConfigError
  static FailureCatalogue shipped();
  /// Adds the failures of a file. @throws base::ConfigError, also for a name that is known already
  void add(const std::filesystem::path& file);

  const std::vector<Failure>& failures() const { return failures_; }
  /// @return nullptr when there is none of that name
  const Failure* find(std::string_view name) const;

  /// For a terminal, and as the table of docs/reference/failures.md.
  std::string text() const;
  std::string markdown() const;

 private:
  std::vector<Failure> failures_;
};

/// What flies a campaign.
enum class CampaignBench { kVirtualClock, kBoard, kFirmware };

/// Why a campaign cannot fly a failure: "needs casd as a program"; nullopt: it can.
std::optional<std::string_view> obstacle(const Failure& failure, CampaignBench bench);

/// The entries of a scenario's `faults` for one failure, as a list in one line of YAML.
///
/// @param title   name of the entries
/// @param when    condition at which it strikes
/// @param values  of its parameters where they are not the usual ones, and `for_s`
std::string faults_of(const Failure& failure, const std::string& title, const std::string& when,
                      const std::map<std::string, double, std::less<>>& values);

}  // namespace cas::hils
