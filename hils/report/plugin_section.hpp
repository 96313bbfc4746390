// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hils/measure/plugin_figure.hpp"
#include "hils/report/html_page.hpp"
#include "hils/report/run_plots.hpp"

namespace cas::hils {

/// The last value of a figure, or "least to greatest" of a series; a dash when it has none.
std::string value_text(const PluginFigure& figure);

/// Tables of the figures of plugins: values, then series.
void add_plugin_tables(HtmlPage& page, const std::vector<PluginFigure>& figures);

/// A plot of each series, named "plugin_PLUGIN_NAME" in letters, digits and _.
void add_plugin_plots(const std::vector<PluginFigure>& figures, NamedPlots& plots);

/// Whether add_plugin_plots() made the plot of this name.
bool is_of_plugin(std::string_view plot_name);

}  // namespace cas::hils
