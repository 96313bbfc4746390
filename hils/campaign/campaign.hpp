// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hils/campaign/catalogue.hpp"
#include "hils/campaign/expectation.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// A moment of the flight: its name, and the condition at which a failure strikes there.
struct CampaignPhase {
  std::string name;
  std::string when;
};

/// One failure of a campaign, and its expectation in each phase.
struct CampaignFailure {
  std::string name;  ///< of the row: the failure's where none is given
  Failure failure;   ///< of the catalogue
  std::map<std::string, double, std::less<>> values{};         ///< of its parameters
  std::map<std::string, std::vector<Expectation>> expected{};  ///< by phase; none: it is not flown
  std::optional<std::string> obstacle{};  ///< why it is not flown: "needs casd as a program"
};

/// Part of a campaign to fly, and its controllers.
struct CampaignChoice {
  std::vector<std::string> controllers{};  ///< of `--fcu`: flown in real time with these
  std::vector<std::string> only{};         ///< names of failures; empty: all
};

/// Contents of a campaign file (config/campaigns/*.yaml). Keys are the members' names.
struct Campaign {
  std::string name;
  std::string description;
  std::filesystem::path scenario;
  std::filesystem::path folder{};  ///< of its file: values of `set` may name files in it
  Architecture architecture = Architecture::kDirect;
  bool on_firmware = false;  ///< stock firmware in software flies it
  std::vector<CampaignPhase> phases{};
  std::vector<std::uint64_t> seeds{};
  double deadline_s = 300;
  std::vector<std::pair<std::string, std::string>> settings{};  ///< as a study's `set`
  std::vector<CampaignFailure> failures{};
  std::vector<std::string> left_out{};     ///< failures of the file that the choice leaves out
  std::vector<std::string> controllers{};  ///< as the choice has them; empty: the virtual clock

  /// In real time, with boards.
  bool is_on_boards() const { return !controllers.empty(); }
  /// Whether a flight is repeatable to the byte: our controller's on the virtual clock.
  bool is_repeatable() const { return !is_on_boards() && !on_firmware; }
  /// Reads and checks a campaign file and its scenario. @throws base::ConfigError
  static Campaign load(const std::filesystem::path& file, const CampaignChoice& choice = {});
};

/// The failures that a campaign file may name: the shipped ones, and those of its own file.
/// @throws base::ConfigError
FailureCatalogue catalogue_of(const std::filesystem::path& campaign);

/// A failure in a phase.
struct CampaignCell {
  std::size_t failure = 0;  ///< index in Campaign::failures
  std::size_t phase = 0;    ///< index in Campaign::phases
};
/// The cells that are flown, failure by failure. The study's point i is cell i - 1; after the last
/// cell comes a point without a failure.
std::vector<CampaignCell> cells_of(const Campaign& campaign);

/// The campaign as a study of `hils sweep`: one parameter, the scenario's `faults`.
std::string study_of(const Campaign& campaign);

}  // namespace cas::hils
