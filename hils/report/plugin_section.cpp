// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/plugin_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

namespace cas::hils {

namespace {

constexpr std::string_view kPrefix = "plugin_";

std::string text(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : "-";
}

/// A name that is safe for a file, and not in `plots` yet.
std::string plot_name(const PluginFigure& figure, const NamedPlots& plots) {
  std::string name = std::string(kPrefix) + figure.plugin + "_" + figure.name;
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_'; },
      '_');
  const auto taken = [&plots](const std::string& candidate) {
    return std::ranges::any_of(plots, [&](const auto& plot) { return plot.first == candidate; });
  };
  if (!taken(name)) return name;
  int number = 2;
  while (taken(fmt::format("{}_{}", name, number))) ++number;
  return fmt::format("{}_{}", name, number);
}

}  // namespace

void add_plugin_tables(const std::vector<PluginFigure>& figures, Document& report) {
  Rows values{{"Plugin", "figure", "value", "unit"}};
  Rows series{{"Plugin", "series", "unit", "samples", "least", "mean", "greatest", "last"}};
  std::uint64_t not_finite = 0;
  for (const PluginFigure& figure : figures) {
    not_finite += figure.not_finite;
    if (figure.series) {
      series.push_back({figure.plugin, figure.name, figure.unit, fmt::format("{}", figure.samples),
                        text(figure.least), text(figure.mean), text(figure.greatest),
                        text(figure.last)});
    } else {
      values.push_back({figure.plugin, figure.name, text(figure.last), figure.unit});
    }
  }
  if (values.size() > 1) report.table("Figures that plugins report", values);
  if (series.size() > 1) report.table("Series that plugins report", series);
  if (not_finite > 0) {
    report.paragraph(
        fmt::format("{} values of plugins were not finite numbers and are left out.", not_finite));
  }
}

void add_plugin_plots(const std::vector<PluginFigure>& figures, NamedPlots& plots) {
  for (const PluginFigure& figure : figures) {
    if (!figure.series || figure.points.empty()) continue;
    plots.emplace_back(plot_name(figure, plots),
                       Plot{.title = figure.plugin + ": " + figure.name,
                            .x_label = kTimeLabel,
                            .y_label = figure.unit,
                            .series = {Series{.name = figure.name, .points = figure.points}}});
  }
}

bool is_of_plugin(std::string_view plot_name) { return plot_name.starts_with(kPrefix); }

}  // namespace cas::hils
