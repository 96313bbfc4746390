// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/report/plot.hpp"

namespace cas::hils {

/// The numbers of a plot for the script of a report, as an HTML element that goes into the plot's
/// figure. Curves of many points are thinned to their extremes. Nothing for a map, which stays a
/// drawing, and where the page was not built: then there is no script either.
std::string plot_block(const Plot& plot);

/// The report with the script that makes plots of its drawings: zoom, one cursor, curves that can
/// be hidden, distances between two points. Unchanged where the page was not built.
std::string with_plot_script(std::string html);

}  // namespace cas::hils
