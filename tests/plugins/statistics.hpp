// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace cas::test {

/// Mean and deviation of a stream of numbers (Welford).
class Statistics {
 public:
  void add(double value) {
    ++count_;
    const double delta = value - mean_;
    mean_ += delta / static_cast<double>(count_);
    sum_squares_ += delta * (value - mean_);
  }
  std::size_t count() const { return count_; }
  double mean() const { return mean_; }
  double stddev() const { return std::sqrt(sum_squares_ / static_cast<double>(count_ - 1)); }

 private:
  std::size_t count_ = 0;
  double mean_ = 0;
  double sum_squares_ = 0;
};

/// Overlapping Allan deviation at the averaging time of `m` samples spaced `dt_s` apart.
inline double allan_deviation(const std::vector<double>& samples, double dt_s, std::size_t m) {
  std::vector<double> integral(samples.size() + 1, 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    integral[i + 1] = integral[i] + samples[i] * dt_s;
  }
  const double tau = static_cast<double>(m) * dt_s;
  const std::size_t terms = integral.size() - 2 * m;
  double sum = 0;
  for (std::size_t i = 0; i < terms; ++i) {
    const double difference = integral[i + 2 * m] - 2.0 * integral[i + m] + integral[i];
    sum += difference * difference;
  }
  return std::sqrt(sum / (2.0 * tau * tau * static_cast<double>(terms)));
}

}  // namespace cas::test
