// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/export.hpp"

namespace cas::base {

/// Everything that a file holds; nullopt when it cannot be opened or read to its end: a folder, a
/// broken disk, the /proc file of a process that has just ended (for which a stream's iterator
/// would throw).
CAS_BASE_EXPORT std::optional<std::string> read_file(const std::filesystem::path& file);

/// Closes a stream of C.
struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, FileCloser>;

/// Opens a file that another person may have made. It never waits: a FIFO or a terminal is refused
/// like every file that is not regular.
/// @param kind  of the file, for the error: "mesh"
/// @throws ConfigError "FILE: KIND cannot be read", "FILE: KIND is no regular file"
CAS_BASE_EXPORT OpenFile open_foreign_file(const std::filesystem::path& file,
                                           std::string_view kind);

/// All bytes of such a file.
/// @param most_bytes  that it may have; /dev/zero ends here, too
/// @throws ConfigError as above, and "FILE: KIND is larger than the 4 MiB that are read"
CAS_BASE_EXPORT std::string read_foreign_file(const std::filesystem::path& file,
                                              std::string_view kind, std::size_t most_bytes);

}  // namespace cas::base
