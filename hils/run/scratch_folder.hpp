// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace cas::hils {

/// Makes a folder PREFIX-RANDOM, and `parent` if need be. @throws base::ConfigError
std::filesystem::path fresh_folder(const std::filesystem::path& parent, const std::string& prefix);

/// A fresh folder that is removed, with its files, when the object is destroyed. Runs, tuning and
/// the environment keep temporary files in one.
class ScratchFolder {
 public:
  /// @throws base::ConfigError
  ScratchFolder(const std::filesystem::path& parent, const std::string& prefix)
      : path_(fresh_folder(parent, prefix)) {}
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace cas::hils
