// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace cas::casd {

inline constexpr std::string_view kTlogExtension = ".tlog";

/// Why a word cannot name a recording, as the end of a sentence; nullopt: it can. A name is a file
/// in one folder, so it must not lead elsewhere: no slash, no leading dot, nothing unprintable.
std::optional<std::string> tlog_name_fault(std::string_view name);

/// "NAME" for "NAME" and "NAME.tlog".
std::string_view bare_tlog_name(std::string_view name);

/// The moment in UTC before the name: "2026-11-22T18-05-00Z-NAME"; without a name the moment alone.
/// @param unix_time  since 1970
std::string dated_tlog_name(std::chrono::seconds unix_time, std::string_view name);

/// Whether a file's name is one that dated_tlog_name() begins: a recording of casd's.
bool is_dated(std::string_view file);

/// Whether one such file is older than another: by date, then by number.
bool older_tlog(std::string_view file, std::string_view other);

/// File `number` of a recording: "NAME.tlog" for 0, "NAME.1.tlog" ...
std::string tlog_file_name(std::string_view name, int number);

}  // namespace cas::casd
