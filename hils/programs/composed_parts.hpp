// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "base/config/config.hpp"
#include "hils/run/run_paths.hpp"
#include "hils/run/run_request.hpp"
#include "hils/scenario/yaml_text.hpp"

namespace YAML {
class Node;
}

namespace cas::hils {

/// {plugin: NAME}
YAML::Node plugin(const char* name);

/// Adds the scenario's further plugins to those of a vehicle of the simulator, and plugin `fault`
/// where it has faults, or takes further ones in flight.
void add_scenario_plugins(const RunRequest& request, std::size_t vehicle,
                          const YAML::Node& plugins);
/// Where their values came from, for errors (base/config/config_origin.hpp).
/// @param first  place of the first of them among the vehicle's plugins
std::string plugin_origins(const Scenario& scenario, std::size_t vehicle, std::size_t first);

/// A file of results as the simulator's plugins take it.
std::string below_out(const VehiclePaths& paths, const std::filesystem::path& file);
/// The plugin that writes truth.csv, and the samples of the sensors where the run keeps them.
YAML::Node recorder_plugin(const RunRequest& request, const VehiclePaths& paths);

/// Name of casd's link for RunRequest::station.
inline constexpr const char* kStationLink = "hils_gcs";
/// A link of casd that accepts packets of ground stations, and none in the name of a vehicle.
YAML::Node ground_link(const RunRequest& request, const std::string& name,
                       const StationEndpoint& station);

}  // namespace cas::hils
