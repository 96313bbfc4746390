// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "hils/measure/plugin_figure.hpp"
#include "hils/report/document.hpp"
#include "hils/report/run_plots.hpp"

namespace cas::hils {

/// Tables of the figures of plugins: values, then series.
void add_plugin_tables(const std::vector<PluginFigure>& figures, Document& report);

/// A plot of each series, named "plugin_PLUGIN_NAME" in letters, digits and _.
void add_plugin_plots(const std::vector<PluginFigure>& figures, NamedPlots& plots);

/// Whether add_plugin_plots() made the plot of this name.
bool is_of_plugin(std::string_view plot_name);

}  // namespace cas::hils
