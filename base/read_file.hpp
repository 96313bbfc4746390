// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/export.hpp"

namespace cas::base {

/// Everything that a file holds; nullopt when it cannot be opened or read to its end: a folder, a
/// broken disk, the /proc file of a process that has just ended (for which a stream's iterator
/// would throw).
CAS_BASE_EXPORT std::optional<std::string> read_file(const std::filesystem::path& file);

}  // namespace cas::base
