// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace cas::hils {

/// Where cells stand in the columns behind the first one, which is left-aligned.
enum class Cells { kLeft, kRight };

/// A table for a terminal: columns as wide as their longest cell, two spaces apart. Widths are
/// counted in characters of UTF-8.
std::string aligned_table(const std::vector<std::vector<std::string>>& rows, Cells cells);

}  // namespace cas::hils
