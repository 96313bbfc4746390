// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "hils/measure/statistics.hpp"

namespace cas::hils {

namespace {

using Binomial = boost::math::binomial_distribution<double>;

double low_end(std::size_t successes, std::size_t trials, double alpha) {
  if (trials == 0 || successes == 0) return 0;
  return Binomial::find_lower_bound_on_p(static_cast<double>(trials),
                                         static_cast<double>(successes), alpha);
}

/// Ranks from 1; equal values share the mean of theirs.
std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&values](std::size_t i) { return values[i]; });
  std::vector<double> result(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    const double rank = (static_cast<double>(begin + 1) + static_cast<double>(end)) / 2;
    for (std::size_t i = begin; i < end; ++i) result[order[i]] = rank;
    begin = end;
  }
  return result;
}

}  // namespace

ShareInterval clopper_pearson(std::size_t successes, std::size_t trials, double confidence) {
  const double alpha = (1 - confidence) / 2;
  ShareInterval interval{.low = low_end(successes, trials, alpha), .high = 1};
  if (trials > 0 && successes < trials) {
    interval.high = Binomial::find_upper_bound_on_p(static_cast<double>(trials),
                                                    static_cast<double>(successes), alpha);
  }
  return interval;
}

double clopper_pearson_low(std::size_t successes, std::size_t trials, double confidence) {
  return low_end(successes, trials, 1 - confidence);
}

double fisher_exact(std::size_t a, std::size_t a_trials, std::size_t b, std::size_t b_trials) {
  const std::size_t successes = a + b;
  const std::size_t trials = a_trials + b_trials;
  if (a_trials == 0 || b_trials == 0 || successes == 0 || successes == trials) return 1;
  const auto all = static_cast<double>(trials);
  const auto of_all = static_cast<double>(successes);
  const auto drawn = static_cast<double>(a_trials);
  const std::size_t least = successes > b_trials ? successes - b_trials : 0;
  const std::size_t most = std::min(successes, a_trials);
  // Hypergeometric likelihood of i successes among the first trials, relative to the most likely
  // one: from each to the next it changes by this ratio. Terms that underflow do not count.
  const auto ratio = [&](std::size_t at) {
    const auto i = static_cast<double>(at);
    return (of_all - i) * (drawn - i) / ((i + 1) * (all - of_all - drawn + i + 1));
  };
  const auto mode =
      std::clamp(static_cast<std::size_t>((drawn + 1) * (of_all + 1) / (all + 2)), least, most);
  std::vector<double> likelihood(most - least + 1, 1.0);
  for (std::size_t i = mode; i < most; ++i) {
    likelihood[i + 1 - least] = likelihood[i - least] * ratio(i);
  }
  for (std::size_t i = mode; i > least; --i) {
    likelihood[i - 1 - least] = likelihood[i - least] / ratio(i - 1);
  }
  constexpr double kEqual = 1 + 1e-7;  // tables that are as likely but for rounding
  const double observed = likelihood[a - least] * kEqual;
  double as_different = 0;
  for (const double each : likelihood) as_different += each <= observed ? each : 0;
  return as_different / std::accumulate(likelihood.begin(), likelihood.end(), 0.0);
}

bool RankCorrelation::is_significant() const {
  return std::abs(rho) * std::sqrt(static_cast<double>(pairs) - 1) > kNormal95;
}

std::optional<RankCorrelation> spearman(std::span<const double> x, std::span<const double> y) {
  std::vector<double> a;
  std::vector<double> b;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    a.push_back(x[i]);
    b.push_back(y[i]);
  }
  if (a.size() < 3) return std::nullopt;
  const std::vector<double> rank_a = ranks(a);
  const std::vector<double> rank_b = ranks(b);
  const double mean = (static_cast<double>(a.size()) + 1) / 2;
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (rank_a[i] - mean) * (rank_b[i] - mean);
    aa += (rank_a[i] - mean) * (rank_a[i] - mean);
    bb += (rank_b[i] - mean) * (rank_b[i] - mean);
  }
  if (aa <= 0 || bb <= 0) return std::nullopt;
  return RankCorrelation{.rho = ab / std::sqrt(aa * bb), .pairs = a.size()};
}

}  // namespace cas::hils
