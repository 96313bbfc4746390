// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cas::hils {

/// A figure that a plugin of a vehicle reports of itself (PluginContext::figure).
struct PluginFigure {
  std::string plugin;  ///< "battery", or "battery#2" for a twin
  std::string name;
  std::string unit;              ///< may be empty
  bool series = false;           ///< a curve over time, else one value
  std::uint64_t samples = 0;     ///< finite values
  std::uint64_t not_finite = 0;  ///< others, which were left out
  std::optional<double> last;    ///< nothing when there was no sample, as for the next three
  std::optional<double> least;   ///< of a series
  std::optional<double> mean;
  std::optional<double> greatest;
  std::vector<std::pair<double, double>> points;  ///< of a series: s of simulated time, value
};

/// The figures of one vehicle from plugin_figures.json of a run; empty when there is no such file.
/// @throws base::ConfigError when the file has another format than the simulator's
std::vector<PluginFigure> read_plugin_figures(const std::filesystem::path& file,
                                              const std::string& vehicle);

}  // namespace cas::hils
