// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "base/export.hpp"

namespace cas::base {

/// Why a file may be another user's work: it belongs neither to root nor to this user, or others
/// may write to it. This user's own group counts as this user, as a umask of 002 has it. Pure but
/// for this process's user and group. @return empty: it is root's or this user's work
CAS_BASE_EXPORT std::string why_untrusted(const struct stat& status);

/// Refuses a file that makes a program run commands, unless it, a symlink at its path and the
/// folder that has it are the work of root or of this user. A folder that others may write into is
/// good if it is sticky. The folders above are as require_kept_folders has them.
/// @throws ConfigError "FILE: belongs to another user; it is not used"
CAS_BASE_EXPORT void require_trusted(const std::filesystem::path& file);

/// Refuses a file if everybody may write into a folder on the way to it, or to what a symlink there
/// names, and so put another one in its place: unless that folder is sticky.
/// @throws ConfigError "FILE: everybody may write into FOLDER (chmod o-w, or +t); it is not used"
CAS_BASE_EXPORT void require_kept_folders(const std::filesystem::path& file);

}  // namespace cas::base
