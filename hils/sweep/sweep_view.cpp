// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <tuple>

namespace cas::hils {

namespace {

std::optional<bool> up_of(const RowResult& result) {
  if (result.row == 0 || !is_judged(result.outcome) || result.figures.empty()) return std::nullopt;
  return result.figures[kUpFigure] == 1;
}

double figure_or(const RowResult& result, std::size_t index, double fallback) {
  if (index >= result.figures.size() || !std::isfinite(result.figures[index])) return fallback;
  return result.figures[index];
}

bool is_log(const Study& study, std::size_t parameter) {
  const auto& distribution = study.parameters[parameter].distribution;
  return distribution && distribution->kind == Distribution::Kind::kLog;
}

ShareChange change_of(const std::string& what, const ShareCell& before, const ShareCell& after) {
  return {.what = what,
          .before = before,
          .after = after,
          .p = fisher_exact(before.successes, before.trials, after.successes, after.trials)};
}

/// Changes by the bins of one parameter, which are those of both sweeps together.
void add_bins(const SweepView& before, const SweepView& after, std::size_t old_parameter,
              std::size_t new_parameter, std::vector<ShareChange>& changes) {
  std::vector<std::string> values = before.values(old_parameter);
  const std::size_t old_rows = values.size();
  const std::vector<std::string> newer = after.values(new_parameter);
  values.insert(values.end(), newer.begin(), newer.end());
  const std::string& name = after.sweep.table.names[new_parameter];
  const Bins all = Bins::of(name, values, is_log(after.sweep.study, new_parameter));
  const auto middle = all.bin_of.begin() + static_cast<std::ptrdiff_t>(old_rows);
  const Bins old_bins{.name = name, .labels = all.labels, .bin_of = {all.bin_of.begin(), middle}};
  const Bins new_bins{.name = name, .labels = all.labels, .bin_of = {middle, all.bin_of.end()}};
  const std::vector<ShareCell> old_cells = count_by(old_bins, before.up());
  const std::vector<ShareCell> new_cells = count_by(new_bins, after.up());
  for (std::size_t i = 0; i < all.labels.size(); ++i) {
    changes.push_back(
        change_of(fmt::format("{} {}: stays up", name, all.labels[i]), old_cells[i], new_cells[i]));
  }
}

/// Holm's method: of n tests, the k-th smallest p is multiplied by n + 1 - k, and never below the
/// one before. @param changes  ascending by p
void correct_by_holm(std::vector<ShareChange>& changes) {
  double least = 0;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    least = std::max(least, std::min(1.0, changes[i].p * static_cast<double>(changes.size() - i)));
    changes[i].p = least;
  }
}

}  // namespace

SweepView SweepView::of(SweepFolder folder) {
  SweepView view{.sweep = std::move(folder), .results = {}};
  view.results = view.sweep.results(1, view.sweep.table.rows.size() + 1);
  return view;
}

SweepCounts SweepView::counts() const { return count(sweep.table.rows.size(), results); }

std::vector<std::optional<bool>> SweepView::up() const {
  std::vector<std::optional<bool>> rows;
  for (const RowResult& result : results) rows.push_back(up_of(result));
  return rows;
}

std::vector<std::string> SweepView::values(std::size_t parameter) const {
  std::vector<std::string> values;
  for (const TableRow& row : sweep.table.rows) values.push_back(row.values[parameter]);
  return values;
}

Bins SweepView::bins(std::size_t parameter) const {
  return Bins::of(sweep.table.names[parameter], values(parameter), is_log(sweep.study, parameter));
}

std::vector<double> SweepView::numbers(std::size_t parameter) const {
  std::vector<double> numbers;
  for (const TableRow& row : sweep.table.rows) {
    const std::string& text = row.values[parameter];
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return {};
    numbers.push_back(value);
  }
  return numbers;
}

std::vector<double> SweepView::figure(std::size_t index) const {
  std::vector<double> values;
  for (const RowResult& result : results) {
    values.push_back(figure_or(result, index, std::numeric_limits<double>::quiet_NaN()));
  }
  return values;
}

std::optional<std::size_t> SweepView::figure_index(const std::string& name) const {
  const auto found = std::ranges::find(sweep.figures, name);
  if (found == sweep.figures.end()) return std::nullopt;
  return static_cast<std::size_t>(found - sweep.figures.begin());
}

std::vector<std::size_t> worst_rows(const SweepView& view, std::size_t count) {
  constexpr double kLast = std::numeric_limits<double>::infinity();
  std::vector<const RowResult*> judged;
  for (const RowResult& result : view.results) {
    if (up_of(result)) judged.push_back(&result);
  }
  std::ranges::sort(judged, {}, [](const RowResult* result) {
    const bool is_up = *up_of(*result);
    return std::tuple(is_up, is_up ? kLast : figure_or(*result, kCrashFigure, kLast),
                      figure_or(*result, kMarginFigure, kLast), result->row);
  });
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < std::min(count, judged.size()); ++i) rows.push_back(judged[i]->row);
  return rows;
}

std::vector<ShareChange> compare_sweeps(const SweepView& before, const SweepView& after) {
  const SweepCounts a = before.counts();
  const SweepCounts b = after.counts();
  std::vector<ShareChange> changes{
      change_of("all: stays up", {a.up, a.judged}, {b.up, b.judged}),
      change_of("all: passed", {a.passed, a.judged}, {b.passed, b.judged}),
      change_of("all: has a verdict", {a.judged, a.flown}, {b.judged, b.flown})};
  std::vector<ShareChange> bins;
  const std::vector<std::string>& old_names = before.sweep.table.names;
  for (std::size_t i = 0; i < after.sweep.table.names.size(); ++i) {
    const auto old = std::ranges::find(old_names, after.sweep.table.names[i]);
    if (old == old_names.end()) continue;
    add_bins(before, after, static_cast<std::size_t>(old - old_names.begin()), i, bins);
  }
  std::ranges::stable_sort(bins, {}, &ShareChange::p);
  correct_by_holm(bins);
  changes.insert(changes.end(), bins.begin(), bins.end());
  return changes;
}

ChangedRows changed_rows(const SweepView& before, const SweepView& after) {
  ChangedRows changed;
  changed.same_table = before.sweep.table.csv() == after.sweep.table.csv();
  if (!changed.same_table) return changed;
  for (std::size_t i = 0; i < after.results.size(); ++i) {
    const std::optional<bool> was = up_of(before.results[i]);
    const std::optional<bool> is = up_of(after.results[i]);
    if (!was || !is || *was == *is) continue;
    (*was ? changed.worse : changed.better).push_back(i + 1);
  }
  return changed;
}

}  // namespace cas::hils
