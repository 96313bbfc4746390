// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cas::hils {

/// With which controllers a campaign is flown, as its folder keeps it for the processes of its
/// flights.
struct CampaignControllers {
  std::vector<std::string> words;  ///< of --fcu
  std::filesystem::path boards;    ///< the list of boards; empty: none
  std::optional<unsigned> baud;    ///< of a port

  void save(const std::filesystem::path& folder) const;
  /// @throws base::ConfigError
  static CampaignControllers load(const std::filesystem::path& folder);
};

/// Flies the task of `folder`/task.json in real time with the boards of its campaign, which the
/// process above holds. Report, replay and logs are left in the row's folder of again/. A board
/// that has flown before is restarted.
///
/// @return exit code, as fly_row(); if a board stops it, the exit code of hils, with the sentence
/// in kBoardSentence
int fly_campaign_row(const std::filesystem::path& folder);

}  // namespace cas::hils
