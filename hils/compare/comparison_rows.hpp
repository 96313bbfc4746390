// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "hils/compare/comparison_table.hpp"

namespace cas::hils {

/// A table as text: headings first, the first column names the row.
using Rows = std::vector<std::vector<std::string>>;

/// Whether any variant has any figure of the group.
bool has_figures(const ColumnGroup& group, const std::vector<VariantResult>& results);
/// A group with one row for each variant; Tables 4 and 5 have the rows of [HILS] below.
Rows group_rows(const ColumnGroup& group, const std::vector<VariantResult>& results);
/// What was lost where and why, one row for each cause.
Rows loss_rows(const std::vector<VariantResult>& results);
/// Differences of the pairs in rates, RMS errors and median delays.
Rows difference_rows(const std::vector<VariantResult>& results);

}  // namespace cas::hils
