// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>

#include "base/error.hpp"

namespace cas::hils {

// Without locks of the file system nothing is refused.
FolderLock::FolderLock(const std::filesystem::path& folder)
    : folder_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (folder_ && ::flock(folder_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw base::ConfigError(folder.string() +
                            ": another run writes its results there; give each its own --out");
  }
}

}  // namespace cas::hils
