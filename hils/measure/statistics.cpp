// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/statistics.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <vector>

#include "base/error.hpp"

namespace cas::hils {

double student_t_95(std::size_t degrees) {
  CAS_CHECK(degrees > 0);
  constexpr double kUpper = 0.975;  // 2.5 % lie beyond it on each side
  return boost::math::quantile(boost::math::students_t(static_cast<double>(degrees)), kUpper);
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
