// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// A value at a time, s.
struct Sample {
  double time_s = 0;
  double value = 0;
};

/// An axis from `low` to `high` whose ends are round numbers.
struct Axis {
  double low = 0;
  double high = 1;
  int decimals = 0;  ///< that its ends need

  std::string label(double value) const;
};
/// The axis that holds these values; a single value gets room on both sides.
Axis round_axis(double low, double high);

/// The span of time, s, that a plot of these samples shows: 10, 30, 60 or 120.
double plot_span_s(const std::deque<Sample>& samples, double now_s);

/// A course over the last seconds, with the ends of both axes: the lower line of the axes is the
/// last of `rows`. @param width  in columns, at least 20 @param rows  at least 3
Block plot(const std::deque<Sample>& samples, double now_s, std::size_t width, std::size_t rows,
           bool unicode);

/// The course in one line of `width` characters at most.
std::string sparkline(const std::deque<Sample>& samples, std::size_t width, bool unicode);

/// Puts the ends of the axes around a drawing: `high` above `low` at its left, `first` and `last`
/// below it.
Block framed(const std::vector<std::string>& drawing, const std::string& high,
             const std::string& low, const std::string& first, const std::string& last,
             bool unicode);

}  // namespace cas::casctl
