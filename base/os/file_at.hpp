// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "base/os/descriptor.hpp"
#include "base/os/write_file.hpp"

namespace cas::base {

/// Which symlinks on the way to a folder are followed.
enum class Symlinks {
  kTrusted,  ///< those that root or this user laid: in a shared folder any user may lay one
  kNone,     ///< and no folder of another user is entered
};

/// Treatment of a folder that does not exist.
enum class Absent { kRefused, kMade };

/// Opens a folder component by component (O_PATH), so that nobody can lead the way elsewhere
/// meanwhile.
/// @param start  folder that a relative path begins at, or AT_FDCWD
/// @param file  that is written there, for errors
/// @throws ConfigError "FILE: cannot be written: 'plots' is a symlink that another user laid"
Descriptor open_folder(int start, const std::filesystem::path& folder, Symlinks symlinks,
                       Absent absent, const std::filesystem::path& file);

/// Whether root or this user laid it.
bool is_trusted_owner(const struct stat& of);

/// Writes a file beside `name` in an open folder ("NAME.PID.new", never over anything) and renames
/// it. @param old  its mode is kept; may be null @return errno, 0 when it is done
int replace_at(int folder, const std::string& name, const struct stat* old, std::string_view text,
               Durability durability);

/// @return errno, 0 when all is written
int write_all(int fd, std::string_view text);

}  // namespace cas::base
