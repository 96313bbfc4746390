// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>

#include "base/export.hpp"
#include "base/os/descriptor.hpp"
#include "base/os/write_file.hpp"
#include "base/read_file.hpp"

namespace cas::base {

/// Place of a file of results: below the folder `out` that a user gave for them.
///
/// The functions of this file follow no symlink below `out`, whoever laid it, and on the way to
/// `out` none of another user: the folders are opened one by one. A symlink in the place of the
/// file itself is replaced.
struct ResultPlace {
  std::filesystem::path out;
  std::filesystem::path file;  ///< relative to `out`, or a path that begins with it

  /// For messages and readers.
  CAS_BASE_EXPORT std::filesystem::path path() const;
};

/// Why a path that a file of configuration gives is not one below the folder of results: it is
/// absolute or has "..". Pure. @return empty: it is one
CAS_BASE_EXPORT std::string_view fault_of_result_path(const std::filesystem::path& path);

/// Makes the folder for results itself and those above it, as far as they are missing.
/// @throws ConfigError
CAS_BASE_EXPORT void make_out_folder(const std::filesystem::path& out);

/// Replaces a file atomically, as write_file() does; missing folders below `out` are made.
/// @throws ConfigError
CAS_BASE_EXPORT void write_result(const ResultPlace& place, std::string_view text,
                                  Durability durability = Durability::kCache);

/// Makes an empty file for writing, in the place of an earlier one; missing folders below `out` are
/// made. @throws ConfigError
CAS_BASE_EXPORT Descriptor make_result(const ResultPlace& place);

/// Opens a file of this run again, to write at its end, or makes it. @throws ConfigError
CAS_BASE_EXPORT Descriptor append_result(const ResultPlace& place);

/// Makes a folder below `out`, which must exist. @throws ConfigError
CAS_BASE_EXPORT void make_result_folder(const ResultPlace& folder);

/// Removes a folder below `out` with all that it holds, if it is there; of a symlink the symlink.
/// @throws ConfigError
CAS_BASE_EXPORT void remove_result_folder(const ResultPlace& folder);

/// Removes a file, if it is there. @throws ConfigError
CAS_BASE_EXPORT void remove_result(const ResultPlace& place);

/// make_result() for buffered writing. @throws ConfigError
CAS_BASE_EXPORT OpenFile open_result(const ResultPlace& place);

/// Closes a file of open_result(). @throws DiskError when the file lacks written bytes
CAS_BASE_EXPORT void close_result(OpenFile file, const ResultPlace& place);

}  // namespace cas::base
