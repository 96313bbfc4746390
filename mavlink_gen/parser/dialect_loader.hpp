// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "mavlink_gen/parser/diagnostics.hpp"
#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::xml {

/// Largest file that is read.
inline constexpr std::size_t kMaxFileBytes = 64U << 20U;

/// Reads a dialect file with all it includes, checks it and merges it.
///
/// Included files come first, each once, however often it is named. Enums of one name become one.
/// Whatever the input: no exception for its faults, nothing evaluated, nothing fetched.
/// @return nullopt when an error was reported
std::optional<Dialect> load_dialect(const std::filesystem::path& file, Diagnostics& diagnostics);

/// The same from text in memory; an <include> is an error.
std::optional<Dialect> parse_dialect(std::string_view text, std::string_view name,
                                     Diagnostics& diagnostics);

}  // namespace cas::mav::xml
