// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/os/descriptor.hpp"

namespace cas::casd {

/// Limits of recordings. 0: no limit.
struct TlogLimits {
  std::uint64_t free_space_min_bytes = 0;  ///< what stays free on the file system
  std::uint64_t max_bytes = 0;             ///< all recordings in the folder together

  friend bool operator==(const TlogLimits&, const TlogLimits&) = default;
};

/// Free space of a folder's file system and size of its recordings.
struct TlogSpace {
  std::uint64_t free_bytes = 0;
  std::uint64_t used_bytes = 0;
};

/// Why `more` bytes must not be recorded, as a clause; empty: they may. Pure.
std::string lack_of_room(const TlogLimits& limits, const TlogSpace& space, std::uint64_t more);

/// The folder of recordings: the operations that need the file system. Files are created in it by
/// name only, never over another file or through a symlink.
class TlogFolder {
 public:
  TlogFolder() = default;
  /// @param path  empty: the working folder
  explicit TlogFolder(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  /// Creates a file, and its folder if only the last path element is missing. @return nothing with
  /// errno set, EEXIST if the name is taken
  base::Descriptor make(const std::string& name) const;
  /// Removes a file or symlink of that name. @return false with errno set
  bool remove(const std::string& name) const;
  /// Free space (unlimited if unknown); with `scan` also the size of all its .tlog
  /// files.
  TlogSpace look(bool scan) const;

 private:
  std::filesystem::path path_ = ".";
};

/// Where recordings go unless the topology says so: the service's own folder for logs
/// ($LOGS_DIRECTORY), else the working folder.
std::filesystem::path default_tlog_folder();

}  // namespace cas::casd
