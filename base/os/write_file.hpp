// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>

#include "base/export.hpp"

namespace cas::base {

/// Whether a file that is written must be on the disk before one goes on.
enum class Durability {
  kDisk,   ///< it outlives a power failure
  kCache,  ///< it outlives this process: the files of one run, and writers that cannot wait
};

/// Writes a file as a whole: whoever reads it finds what it held before, or all of `text`. It is
/// written beside the file ("FILE.PID.new", never over anything) and renamed. An existing file
/// keeps its mode; what is no regular file (a pipe, /dev/stdout) is written as it is. A symlink
/// keeps its place where this user or root laid it and it leads to a file; any other one is
/// refused.
/// @throws ConfigError "FILE: cannot be written: No space left on device"; then the file is as it
/// was and nothing lies beside it
CAS_BASE_EXPORT void write_file(const std::filesystem::path& file, std::string_view text,
                                Durability durability = Durability::kDisk);

}  // namespace cas::base
