// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/composed_parts.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <string_view>
#include <utility>

#include "base/config/config_origin.hpp"
#include "base/config/install_paths.hpp"
#include "casd/packet/own_station.hpp"
#include "hils/programs/composition.hpp"

namespace cas::hils {

YAML::Node plugin(const char* name) {
  YAML::Node node(YAML::NodeType::Map);
  node["plugin"] = name;
  return node;
}

namespace {

/// Keys of plugins that name a file.
constexpr std::array<std::pair<std::string_view, const char*>, 2> kFileKeys{
    {{"wind", "grid"}, {"lidar", "pattern"}}};

/// Entry of a plugin of the scenario; the file that it names is given by its full path.
YAML::Node further_plugin(const base::ConfigNode& entry) {
  YAML::Node node = copy(entry);
  const auto name = entry.at("plugin").as<std::string>();
  for (const auto& [plugin, key] : kFileKeys) {
    if (name != plugin) continue;
    if (const auto file = entry.find(key))
      node[key] = std::filesystem::weakly_canonical(base::find_config(*file)).string();
  }
  return node;
}

/// Entry of plugin `fault` for this vehicle; nullopt when it has no faults.
/// @param by_hand  it takes further ones in flight
std::optional<YAML::Node> fault_plugin(const Scenario& scenario, std::size_t vehicle,
                                       bool by_hand) {
  YAML::Node faults;
  for (const VehicleFault& fault : scenario.faults.of_vehicle(vehicle)) {
    faults.push_back(copy(fault.script));
    faults[faults.size() - 1].remove("vehicle");
  }
  if (faults.size() == 0 && !by_hand) return std::nullopt;
  YAML::Node node = plugin("fault");
  if (faults.size() > 0) node["faults"] = faults;
  if (by_hand) node["by_hand"] = true;
  return node;
}

}  // namespace

void add_scenario_plugins(const RunRequest& request, std::size_t vehicle,
                          const YAML::Node& plugins) {
  YAML::Node list = plugins;  // the same list: a node is a handle
  const Scenario& scenario = request.scenario;
  for (const base::ConfigNode& further : scenario.plugins) {
    list.push_back(further_plugin(further));
  }
  const bool by_hand = request.live != nullptr ||
                       (request.station && request.station->inject_failures) ||
                       (scenario.firmware && scenario.firmware->external_ahrs);
  if (const auto faults = fault_plugin(scenario, vehicle, by_hand)) list.push_back(*faults);
}

std::string plugin_origins(const Scenario& scenario, std::size_t vehicle, std::size_t first) {
  const auto path = [vehicle](std::size_t number) {
    return fmt::format("vehicles[{}].plugins[{}]", vehicle, number);
  };
  std::string notes;
  std::size_t plugin = first;
  for (const base::ConfigNode& further : scenario.plugins) {
    notes += base::origin_notes(path(plugin++), further);
  }
  std::size_t number = 0;
  for (const VehicleFault& fault : scenario.faults.of_vehicle(vehicle)) {
    notes += base::origin_notes(fmt::format("{}.faults[{}]", path(plugin), number++), fault.script);
  }
  return notes;
}

std::string below_out(const VehiclePaths& paths, const std::filesystem::path& file) {
  return file.lexically_relative(paths.out).string();
}

YAML::Node recorder_plugin(const RunRequest& request, const VehiclePaths& paths) {
  YAML::Node recorder = plugin("recorder");
  recorder["file"] = below_out(paths, paths.truth_csv());
  recorder["rate_hz"] = kTruthHz;
  recorder["clouds"] = below_out(paths, paths.clouds_csv());
  if (request.keeps_sensors) recorder["sensor_dir"] = below_out(paths, paths.sensors());
  return recorder;
}

YAML::Node ground_link(const RunRequest& request, const std::string& name,
                       const StationEndpoint& station) {
  YAML::Node link;
  link["name"] = name;
  link["type"] = station.type;
  link[station.is_server() ? "local" : "remote"] = station.address;
  link["accept"]["traffic"] = "ground_station";
  for (const std::uint8_t vehicle : request.scenario.systems()) {
    link["accept"]["block_systems"].push_back(static_cast<int>(vehicle));
  }
  // Packets of casd's own station are not taken for an outside act.
  link["accept"]["block_systems"].push_back(static_cast<int>(casd::kOwnStation.system));
  if (station.inject_failures) link["inject_failures"] = true;
  return link;
}

}  // namespace cas::hils
