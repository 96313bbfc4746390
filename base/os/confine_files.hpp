// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/export.hpp"

namespace cas::base {

/// What confine_files() confines.
enum class FileUse : std::uint8_t {
  kRead,  ///< opening files for reading, listing folders
  kWrite  ///< opening files for writing, making, renaming and removing files, folders and sockets
};

/// Confines the calling thread, and threads and programs that it starts from now on, for good: from
/// then on `use` is possible only at these files and below these folders; elsewhere the kernel says
/// EACCES. Open files stay open, and connecting to a socket stays possible. A second call can only
/// confine further. A path that does not exist is passed over.
/// @return false, and nothing is confined, where the kernel has no Landlock (Linux before 5.13, or
/// switched off; Linux, Documentation/userspace-api/landlock.rst)
CAS_BASE_EXPORT bool confine_files(FileUse use, const std::vector<std::filesystem::path>& places);

}  // namespace cas::base
