// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cas::hils {

/// Numbers between commas; nullopt where anything else is in the line.
std::optional<std::vector<double>> parse_csv_row(std::string_view line);

/// Reads the next line of a file. @return false at its end
/// @param file  its path, for the error message
/// @throws base::ConfigError when reading fails before the end
bool next_line(std::istream& in, std::string& line, const std::filesystem::path& file);

}  // namespace cas::hils
