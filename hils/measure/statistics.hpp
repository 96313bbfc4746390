// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

namespace cas::hils {

/// Two-sided 95 % quantile of the standard normal distribution.
inline constexpr double kNormal95 = 1.959964;

/// Mean of a set of runs with its 95 % confidence interval.
struct Mean {
  double mean = 0;
  double half_width = 0;  ///< of the interval, by Student's t; 0 with fewer than two values
  std::size_t count = 0;
};

Mean mean_of(std::span<const double> values);

/// Mean of the differences a[i] - b[i]: runs with the same seed compared with each other.
Mean mean_difference(std::span<const double> a, std::span<const double> b);

/// Two-sided 95 % quantile of Student's t with `degrees` degrees of freedom, from 1.
double student_t_95(std::size_t degrees);

}  // namespace cas::hils
