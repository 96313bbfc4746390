// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace cas::hils {

/// Numbers between commas; nullopt where anything else is in the line.
std::optional<std::vector<double>> parse_csv_row(std::string_view line);

}  // namespace cas::hils
