// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace cas::hils {

/// One curve of a plot.
struct Series {
  std::string name{};
  std::vector<std::pair<double, double>> points{};  ///< x ascending, unless scales are equal
  bool dashed = false;                              ///< for references
  bool steps = false;                               ///< for counts and histograms
  bool dots = false;                                ///< points without a line between them
};

/// A moment that is marked across a plot (a fault, the begin of a step).
struct Mark {
  double x = 0;
  std::string text{};
  bool fault = false;  ///< drawn in red
};

/// Curves and marks in one pair of axes, which fit the data.
struct Plot {
  std::string title{};
  std::string x_label{};
  std::string y_label{};
  std::vector<Series> series{};
  std::vector<Mark> marks{};
  bool log_x = false;                      ///< decades; x must be positive
  bool log_y = false;                      ///< the same; other values are left out
  bool from_zero = false;                  ///< y axis starts at 0
  bool equal_scales = false;               ///< a unit is as long in x as in y: a map
  std::pair<double, double> shaded{0, 0};  ///< x range with a tint (the measured stretch)
};

/// Draws the plot as an SVG element of fixed width for use alone or inside HTML, in dark colours
/// where the reader prefers them. Texts of marks have rows of their own above the axes. Curves of
/// many points are thinned to their extremes per pixel.
std::string to_svg(const Plot& plot);

/// Text with the characters that XML reserves escaped.
std::string escape_xml(const std::string& text);

}  // namespace cas::hils
