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

/// Replaces a file atomically: a reader sees the old content or the new. The new content is written
/// beside the file ("FILE.PID.new", never over anything) and renamed. An existing file keeps its
/// mode; a pipe or a device (/dev/stdout) is written in place. A symlink is followed when this user
/// or root owns it and its target exists; otherwise the file is refused.
/// @throws ConfigError "FILE: cannot be written: No space left on device"; then the file is as it
/// was and nothing lies beside it
CAS_BASE_EXPORT void write_file(const std::filesystem::path& file, std::string_view text,
                                Durability durability = Durability::kDisk);

}  // namespace cas::base
