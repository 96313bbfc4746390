// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hils/compare/comparison.hpp"
#include "hils/measure/statistics.hpp"
#include "hils/scenario/figure.hpp"

namespace cas::hils {

/// A column of a table: a row of figure_table().
using FigureColumn = const Figure<Measurement>*;

/// Whose rows stand below ours.
enum class PaperTable { kNone, kRates, kRms };

/// Columns that stand in one table.
struct ColumnGroup {
  std::string title;
  std::vector<FigureColumn> columns;
  PaperTable paper = PaperTable::kNone;
};

/// All tables of a comparison: Tables 4 and 5 of [HILS] first, then figures beyond the paper.
const std::vector<ColumnGroup>& comparison_groups();

/// Mean and interval over the valid runs that have the figure.
std::optional<Mean> mean_of_valid(const VariantResult& result, FigureColumn column);
/// Mean and interval of the differences a - b over the seeds that are valid in both.
std::optional<Mean> difference_of(const VariantResult& a, const VariantResult& b,
                                  FigureColumn column);
/// The pairs that are worth a difference: TCAS less each other one at the same baud rate, and less
/// SITL.
std::vector<std::pair<std::size_t, std::size_t>> comparison_pairs(
    const std::vector<VariantResult>& results);

/// "499.9731 +- 0.0012", or "-" for nothing.
std::string to_text(const std::optional<Mean>& mean, int digits);

/// Losses by message and cause, summed over the valid runs: "HIL_SENSOR: too old ...", count.
std::map<std::string, std::uint64_t> losses_of(const VariantResult& result);
/// Packets sent of all three messages in the valid runs.
std::uint64_t sent_of(const VariantResult& result);

/// Whether any variant has any figure of the group.
bool has_figures(const ColumnGroup& group, const std::vector<VariantResult>& results);
/// A group with one row for each variant; Tables 4 and 5 have the rows of [HILS] below, the latter
/// where a vehicle that kept its place was measured.
Rows group_rows(const ColumnGroup& group, const std::vector<VariantResult>& results);
/// Lost packets, one row for each cause.
Rows loss_rows(const std::vector<VariantResult>& results);
/// Differences of the pairs in rates, RMS errors and median delays.
Rows difference_rows(const std::vector<VariantResult>& results);

}  // namespace cas::hils
