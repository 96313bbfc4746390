// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/tlog/tlog_name.hpp"

namespace cas::casd {

/// How many logs of one kind stay in their folder (`log.keep`); 0: no limit.
struct LogLimits {
  /// Logs pause before the disk is full, where they would take others with them.
  static constexpr std::uint64_t kFreeSpaceMin = 64 * 1024 * 1024;

  std::uint64_t free_space_min_bytes = 0;    ///< bytes that stay free on the file system
  std::optional<std::uint64_t> max_bytes{};  ///< all logs together; nullopt: the kind's own limit
  int max_files = 0;                         ///< logs that casd has named itself
  bool delete_oldest = false;                ///< LogFolder::make_room instead of a pause

  friend bool operator==(const LogLimits&, const LogLimits&) = default;
};

/// Free and used space of a folder of recordings.
struct LogSpace {
  std::uint64_t free_bytes = 0;
  std::uint64_t used_bytes = 0;
};

/// Why `more` bytes must not be recorded, as a clause; nullopt: they may. Pure.
std::optional<std::string> lack_of_room(const LogLimits& limits, const LogSpace& space,
                                        std::uint64_t more);

/// A folder of logs of one kind: all access to its file system. Files are made by name only; no
/// file is replaced and no symlink followed. A file is locked for writing (file_lock.hpp) while it
/// is written.
class LogFolder {
 public:
  using Extensions = std::vector<std::string_view>;
  /// Whether casd has given a file its name.
  using IsOwn = bool (*)(std::string_view file);

  LogFolder() : LogFolder(std::filesystem::path()) {}
  /// @param path        empty: the working folder
  /// @param extensions  of its recordings: ".tlog"
  /// @param is_own      tells the recordings that may be removed
  explicit LogFolder(std::filesystem::path path, Extensions extensions = {kTlogExtension},
                     IsOwn is_own = is_dated);

  const std::filesystem::path& path() const { return path_; }
  /// Makes a file, and the folder if its parent exists. @return nothing with errno set, EEXIST if
  /// the name is taken
  base::Descriptor make(const std::string& name) const;
  /// Writes a test file and removes it: free space alone does not prove that the disk takes one.
  /// @return false with errno set
  bool takes_files() const;
  /// Removes a file or symlink of that name. @return false with errno set
  bool remove(const std::string& name) const;
  /// Why no log could begin now, with room for `room` bytes, as a clause; nullopt: one could.
  std::optional<std::string> hindrance(const LogLimits& limits, std::uint64_t room) const;
  /// Removes the oldest, as remove_oldest does, and says so in casd's log.
  /// @param max_files  that may stay; 0: all
  void keep_newest(int max_files, const std::string& current) const;
  /// Removes the oldest of casd's recordings (IsOwn) until `keep` of them are left: only
  /// regular files of this user that no program writes. `current` stays. @return removed files
  std::vector<std::string> remove_oldest(std::size_t keep, const std::string& current) const;
  /// Why `more` bytes do not fit into the limits, as a clause; nullopt: they do, or would if old
  /// recordings were removed that may be (`delete_oldest`).
  std::optional<std::string> lack(const LogLimits& limits, std::uint64_t more,
                                  const std::string& current) const;
  /// Removes the oldest, as remove_oldest does, until `more` bytes fit into the limits; none where
  /// all of them would not suffice. Says so in casd's log. @return removed files
  std::vector<std::string> make_room(const LogLimits& limits, std::uint64_t more,
                                     const std::string& current) const;
  /// Free space (unlimited if the file system does not say), and with `scan` the space of all its
  /// recordings.
  LogSpace look(bool scan) const;

 private:
  struct File {
    std::string name;
    std::uint64_t bytes = 0;
    std::int64_t written_s = 0;  ///< last write, Unix time
  };
  /// Recordings that may be removed, that with the oldest last write first; of one second by their
  /// names.
  std::vector<File> removable(const std::string& current) const;

  std::filesystem::path path_;
  Extensions extensions_;
  IsOwn is_own_;
};

/// Writes as much as the disk takes. @return how many bytes; fewer than all with errno set
std::size_t write_some(int fd, std::span<const std::uint8_t> bytes);

/// Whether an open file was deleted (link count 0): later writes to it are lost.
bool is_deleted(const base::Descriptor& file);

/// Where recordings go unless the topology says so: the service's own folder for logs
/// ($LOGS_DIRECTORY), else the working folder.
std::filesystem::path default_log_folder();

}  // namespace cas::casd
