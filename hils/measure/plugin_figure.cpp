// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/plugin_figure.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.hpp"

namespace cas::hils {

namespace {

using nlohmann::json;

std::optional<double> number(const json& figure, const char* key) {
  const auto found = figure.find(key);
  return found == figure.end() || !found->is_number() ? std::nullopt
                                                      : std::optional(found->get<double>());
}

PluginFigure parse(const json& figure) {
  PluginFigure result{.plugin = figure.at("plugin").get<std::string>(),
                      .name = figure.at("name").get<std::string>(),
                      .unit = figure.at("unit").get<std::string>(),
                      .series = figure.at("kind").get<std::string>() == "series",
                      .samples = figure.at("samples").get<std::uint64_t>(),
                      .not_finite = figure.at("not_finite").get<std::uint64_t>(),
                      .last = number(figure, "last"),
                      .least = number(figure, "min"),
                      .mean = number(figure, "mean"),
                      .greatest = number(figure, "max"),
                      .points = {}};
  if (result.series) {
    for (const json& point : figure.at("points")) {
      result.points.emplace_back(point.at(0).get<double>(), point.at(1).get<double>());
    }
  }
  return result;
}

}  // namespace

std::vector<PluginFigure> read_plugin_figures(const std::filesystem::path& file,
                                              const std::string& vehicle) {
  std::vector<PluginFigure> figures;
  std::ifstream in(file);
  if (!in) return figures;
  try {
    const json file_content = json::parse(in);
    for (const json& figure : file_content.at("figures")) {
      if (figure.at("vehicle").get<std::string>() == vehicle) figures.push_back(parse(figure));
    }
  } catch (const json::exception&) {
    throw base::ConfigError(file.string() + ": is no file of plugins' figures");
  }
  return figures;
}

}  // namespace cas::hils
