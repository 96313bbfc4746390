// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hils/sweep/row_result.hpp"
#include "hils/sweep/study.hpp"

namespace cas::hils {

/// Numbers of runs of a sweep by result.
struct SweepCounts {
  std::size_t rows = 0;    ///< planned
  std::size_t flown = 0;   ///< with a result
  std::size_t judged = 0;  ///< with a verdict
  std::size_t up = 0;
  std::size_t passed = 0;

  std::size_t of(Share share) const;
};
SweepCounts count(std::size_t rows, const std::vector<RowResult>& results);

/// A limit of a study, judged.
struct ShareCheck {
  ShareLimit limit;
  std::size_t successes = 0;
  std::size_t trials = 0;  ///< all runs that were flown: one without a verdict counts against it
  double low = 0;          ///< one-sided Clopper-Pearson bound at the limit's confidence
  bool kept = false;
  /// "up: 995 of 1000 (99.50 %), at least 98.96 % at 95 % confidence; the limit is 99.9 %"
  std::string sentence() const;
};
std::vector<ShareCheck> check_shares(const std::vector<ShareLimit>& limits,
                                     const SweepCounts& counts);

/// JUnit XML: a case for each limit, and one that fails when runs are missing.
std::string sweep_junit(const std::string& name, const SweepCounts& counts,
                        const std::vector<ShareCheck>& checks, const FlightWarnings& warnings);

}  // namespace cas::hils
