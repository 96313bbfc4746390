// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "hils/report/document.hpp"
#include "hils/sweep/sweep_statistics.hpp"

namespace cas::hils {

/// The values of one parameter, in bins.
struct Bins {
  std::string name{};
  std::vector<std::string> labels{};  ///< of each bin: a value, or "1.2..1.5"
  std::vector<std::size_t> bin_of{};  ///< of each row

  /// Each value a bin where there are at most `most` different ones, or where one is no number;
  /// else `most` bins, equally wide, or of equal ratio where `log`.
  static Bins of(const std::string& name, const std::vector<std::string>& values, bool log,
                 std::size_t most = 8);
};

/// Runs of one cell of a map, or one bin.
struct ShareCell {
  std::size_t successes = 0;
  std::size_t trials = 0;

  ShareInterval interval() const { return clopper_pearson(successes, trials); }
  double share() const {
    return trials > 0 ? static_cast<double>(successes) / static_cast<double>(trials) : 0;
  }
  /// Where the 95 % interval lies: 1 above one half, -1 below it, 0 about it or nothing flown.
  int side() const;
};

/// Successes by bins. @param success  of each row: nothing where it has no verdict
std::vector<ShareCell> count_by(const Bins& bins, const std::vector<std::optional<bool>>& success);
/// The same by two parameters: cell (i, j) of x bin i and y bin j is at j * x.labels.size() + i.
std::vector<ShareCell> count_by(const Bins& x, const Bins& y,
                                const std::vector<std::optional<bool>>& success);

/// The map as a table, the first bin of y at the bottom as in a plot: colour and number are the
/// share in percent; a frame is around cells whose interval is above one half; a "?" has its
/// interval about it.
Document::Table success_map(const Bins& x, const Bins& y, const std::vector<ShareCell>& cells);

}  // namespace cas::hils
