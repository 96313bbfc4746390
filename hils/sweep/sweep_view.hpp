// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "hils/sweep/row_result.hpp"
#include "hils/sweep/share_limits.hpp"
#include "hils/sweep/success_map.hpp"
#include "hils/sweep/sweep_folder.hpp"

namespace cas::hils {

/// A sweep and its results so far, as tables and pages see it.
struct SweepView {
  SweepFolder sweep;
  std::vector<RowResult> results;  ///< results[i] is row i + 1; row 0 where it has not been flown

  static SweepView of(SweepFolder folder);

  SweepCounts counts() const;
  /// Whether each row stayed up; nullopt where it has no verdict.
  std::vector<std::optional<bool>> up() const;
  /// Values of one parameter by row, and in bins.
  std::vector<std::string> values(std::size_t parameter) const;
  Bins bins(std::size_t parameter) const;
  /// The same as numbers; empty where one of them is none.
  std::vector<double> numbers(std::size_t parameter) const;
  /// A figure by row; NaN where a row has none.
  std::vector<double> figure(std::size_t index) const;
  /// Place of the figure of that name.
  std::optional<std::size_t> figure_index(const std::string& name) const;
};

/// The rows that went worst, at most `count`: first those that did not stay up, by the time of
/// their first incident, then by the least margin to a limit. Rows without a verdict are left out.
std::vector<std::size_t> worst_rows(const SweepView& view, std::size_t count);

/// One share in two sweeps.
struct ShareChange {
  std::string what{};  ///< "all: stays up", "wind_m_s 4..6: stays up"
  ShareCell before{};
  ShareCell after{};
  double p = 1;  ///< Fisher's exact test; of the bins, corrected by Holm's method for their number

  double change() const { return after.share() - before.share(); }
};

/// Changes from one sweep to another: the shares of all runs (stays up, passed), then of each bin
/// of each parameter that both have, the most certain change first.
std::vector<ShareChange> compare_sweeps(const SweepView& before, const SweepView& after);

/// Rows with another result: `worse` stayed up in the first sweep alone, `better` in the second
/// alone. Both are empty where the tables differ.
struct ChangedRows {
  bool same_table = false;
  std::vector<std::size_t> worse{};
  std::vector<std::size_t> better{};
};
ChangedRows changed_rows(const SweepView& before, const SweepView& after);

}  // namespace cas::hils
