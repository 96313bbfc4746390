// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/statistics.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "base/error.hpp"

namespace cas::hils {

namespace {

// Two-sided 95 % quantiles for 1..30 degrees of freedom (any table of Student's distribution).
constexpr std::array<double, 30> kStudent95{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306,
                                            2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120,
                                            2.110,  2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064,
                                            2.060,  2.056, 2.052, 2.048, 2.045, 2.042};

}  // namespace

double student_t_95(std::size_t degrees) {
  CAS_CHECK(degrees > 0);
  if (degrees <= kStudent95.size()) return kStudent95[degrees - 1];
  // First terms of the expansion in 1/n about the normal quantile: 1e-4 beyond 30.
  const double n = static_cast<double>(degrees);
  const double z = kNormal95;
  return z + (z * z * z + z) / (4 * n) +
         (5 * std::pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * n * n);
}

Mean mean_of(std::span<const double> values) {
  Mean result{.mean = 0, .half_width = 0, .count = values.size()};
  if (values.empty()) return result;
  const double n = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / n;
  if (values.size() < 2) return result;
  double squares = 0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  result.half_width = student_t_95(values.size() - 1) * std::sqrt(squares / (n - 1) / n);
  return result;
}

Mean mean_difference(std::span<const double> a, std::span<const double> b) {
  CAS_CHECK(a.size() == b.size());
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i) differences.push_back(a[i] - b[i]);
  return mean_of(differences);
}

}  // namespace cas::hils
