// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace cas::hils {

/// Ends of a confidence interval of a share, 0 to 1.
struct ShareInterval {
  double low = 0;
  double high = 1;
};

/// Two-sided interval of Clopper and Pearson ([Clopper-Pearson]): it holds the true share at least
/// as often as `confidence` says. All of [0, 1] where there are no trials.
ShareInterval clopper_pearson(std::size_t successes, std::size_t trials, double confidence = 0.95);

/// The lower end alone, one-sided at `confidence`.
double clopper_pearson_low(std::size_t successes, std::size_t trials, double confidence);

/// Fisher's exact test, two-sided: how likely shares at least as different as `a` of `a_trials` and
/// `b` of `b_trials` are when both come from the same odds. 1 where one has no trials.
double fisher_exact(std::size_t a, std::size_t a_trials, std::size_t b, std::size_t b_trials);

/// Spearman's rank correlation of pairs (x[i], y[i]); ties have the mean of their ranks. Pairs with
/// a value that is no number are left out. Nothing where fewer than three are left, or one of both
/// never changes.
struct RankCorrelation {
  double rho = 0;
  std::size_t pairs = 0;

  /// Whether it differs from 0 at 95 %, by the normal approximation of rho sqrt(n - 1).
  bool is_significant() const;
};
std::optional<RankCorrelation> spearman(std::span<const double> x, std::span<const double> y);

}  // namespace cas::hils
