// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace cas::hils {

/// A finished run below a folder.
struct ListedRun {
  std::string folder{};  ///< relative to the folder that was searched; "." for itself
  std::string verdict{};
  std::string scenario{};
  std::string controller{};  ///< "PX4 1.16.0"; empty for our own and for boards
  std::string architecture{};
  std::string clock{};  ///< "virtual", "lockstep" or "real time"
  std::uint64_t seed = 0;
  std::int64_t ended_s = 0;  ///< since 1970
  std::string why{};         ///< the first sentence of its failures
  /// Every number of its summary by its path there; those of several vehicles begin with a name.
  std::map<std::string, double> figures{};
  /// Values of its effective configuration by their key paths: "hilsim.plugins[wind].mean_m_s".
  std::map<std::string, std::string> settings{};

  /// The number of a path in the summary.
  std::optional<double> figure(const std::string& path) const;
};

/// Finished runs below a folder, the latest first. Symlinks are not followed.
struct RunList {
  std::vector<ListedRun> runs;
  std::vector<std::string> unread;  ///< a sentence for each summary that cannot be read
};

/// @throws base::ConfigError when there is no such folder
RunList find_runs(const std::filesystem::path& folder);

/// A table for a terminal.
std::string run_table(const std::vector<ListedRun>& runs);

}  // namespace cas::hils
