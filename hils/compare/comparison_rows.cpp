// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/comparison_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "hils/report/paper_figures.hpp"

namespace cas::hils {

namespace {

constexpr std::array<std::string_view, 11> kCompared{
    "sensor_hz", "gps_hz",        "controls_hz",     "x_m",        "y_m", "z_m", "yaw_rad",
    "gps_pct",   "uplink_p50_us", "downlink_p50_us", "loop_p99_us"};

void add_paper_rows(const ColumnGroup& group, Rows& rows) {
  if (group.key == "rates") {
    for (const PaperRates& row : kPaperTable4) {
      rows.push_back({fmt::format("[HILS] {}", row.name)});
      for (const double value : {row.sensor_hz, row.sensor_error_pct, row.gps_hz, row.gps_error_pct,
                                 row.controls_hz, row.controls_error_pct}) {
        rows.back().push_back(fmt::format("{:.4f}", value));
      }
    }
  }
  if (group.key == "rms") {
    for (const PaperRms& row : kPaperTable5) {
      rows.push_back({fmt::format("[HILS] {}", row.name)});
      for (const double value : {row.x_m, row.y_m, row.z_m, row.yaw_rad}) {
        rows.back().push_back(fmt::format("{:.4f}", value));
      }
    }
  }
}

}  // namespace

bool has_figures(const ColumnGroup& group, const std::vector<VariantResult>& results) {
  return std::ranges::any_of(results, [&](const VariantResult& result) {
    return std::ranges::any_of(group.columns, [&](const Column& column) {
      return estimate_of(result, column).has_value();
    });
  });
}

Rows group_rows(const ColumnGroup& group, const std::vector<VariantResult>& results) {
  Rows rows{{""}};
  for (const Column& column : group.columns) rows.front().push_back(column.title);
  for (const VariantResult& result : results) {
    rows.push_back({result.variant.name()});
    for (const Column& column : group.columns) {
      rows.back().push_back(to_text(estimate_of(result, column), column.digits));
    }
  }
  add_paper_rows(group, rows);
  return rows;
}

Rows loss_rows(const std::vector<VariantResult>& results) {
  Rows rows{{"", "packets lost", "of", "what and where"}};
  for (const VariantResult& result : results) {
    const std::uint64_t sent = sent_of(result);
    const auto losses = losses_of(result);
    if (losses.empty()) {
      rows.push_back({result.variant.name(), "0", fmt::format("{}", sent), ""});
    }
    for (const auto& [cause, count] : losses) {
      rows.push_back(
          {result.variant.name(), fmt::format("{}", count), fmt::format("{}", sent), cause});
    }
  }
  return rows;
}

Rows difference_rows(const std::vector<VariantResult>& results) {
  Rows rows{{""}};
  std::vector<Column> columns;
  for (const ColumnGroup& group : comparison_groups()) {
    for (const Column& column : group.columns) {
      if (std::ranges::count(kCompared, column.key) == 0) continue;
      columns.push_back(column);
      rows.front().push_back(column.key);
    }
  }
  for (const auto& [a, b] : comparison_pairs(results)) {
    rows.push_back({results[a].variant.name() + " less " + results[b].variant.name()});
    for (const Column& column : columns) {
      rows.back().push_back(to_text(difference_of(results[a], results[b], column), column.digits));
    }
  }
  return rows;
}

}  // namespace cas::hils
