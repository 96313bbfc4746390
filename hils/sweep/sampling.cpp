// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sampling.hpp"

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <numeric>
#include <utility>

#include "base/random.hpp"

namespace cas::hils {

namespace {

constexpr double kTwoToMinus53 = 1.0 / 9007199254740992.0;

/// Into the open interval: quantiles have no value at its ends.
double inside(double u) { return std::clamp(u, kTwoToMinus53, 1 - kTwoToMinus53); }

/// 0 to count - 1 in an order drawn by Fisher and Yates' method.
std::vector<std::size_t> shuffled(std::size_t count, base::NormalRandom& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = count; i > 1; --i) {
    const auto other = static_cast<std::size_t>(random.uniform() * static_cast<double>(i));
    std::swap(order[i - 1], order[std::min(other, i - 1)]);
  }
  return order;
}

std::vector<double> random_column(Sampling sampling, std::size_t count, std::uint64_t seed) {
  base::NormalRandom random(seed);
  std::vector<double> column(count);
  if (sampling == Sampling::kRandom) {
    for (double& u : column) u = inside(random.uniform());
    return column;
  }
  const std::vector<std::size_t> strata = shuffled(count, random);
  for (std::size_t i = 0; i < count; ++i) {
    column[i] =
        inside((static_cast<double>(strata[i]) + random.uniform()) / static_cast<double>(count));
  }
  return column;
}

std::vector<std::vector<double>> sobol_points(std::size_t count, std::size_t dimensions) {
  boost::random::sobol engine(dimensions);
  std::vector<std::vector<double>> points(count, std::vector<double>(dimensions));
  for (std::vector<double>& point : points) {
    for (double& u : point) u = inside(static_cast<double>(engine() >> 11U) * kTwoToMinus53);
  }
  return points;
}

}  // namespace

std::vector<std::vector<double>> unit_points(Sampling sampling, std::size_t count,
                                             const std::vector<std::string>& names,
                                             std::uint64_t seed) {
  if (sampling == Sampling::kNone || names.empty()) return {};
  if (sampling == Sampling::kSobol) return sobol_points(count, names.size());
  std::vector<std::vector<double>> points(count, std::vector<double>(names.size()));
  for (std::size_t j = 0; j < names.size(); ++j) {
    const std::vector<double> column =
        random_column(sampling, count, base::derive_seed(seed, "sweep " + names[j]));
    for (std::size_t i = 0; i < count; ++i) points[i][j] = column[i];
  }
  return points;
}

}  // namespace cas::hils
