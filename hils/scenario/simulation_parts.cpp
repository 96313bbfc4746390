// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/simulation_parts.hpp"

#include <yaml-cpp/yaml.h>

#include "base/config/config_origin.hpp"
#include "base/config/weather_keys.hpp"
#include "base/earth/gravity.hpp"
#include "hils/scenario/yaml_text.hpp"

namespace cas::hils {

std::vector<std::string> first_plugins(const std::filesystem::path& vehicle, bool sensors) {
  std::vector<std::string> names(kFirstPlugins.begin(), kFirstPlugins.end());
  if (!sensors) names.resize(1);
  const bool has_wings = base::ConfigNode::load(vehicle).has(kAeroPlugin);
  if (has_wings) names.insert(names.begin() + 1, kAeroPlugin);
  return names;
}

void put_world(const Scenario& scenario, YAML::Node& root) {
  const ScenarioWorld& world = scenario.world;
  if (world.sdf.empty()) {
    root["world"]["gravity_m_s2"] = base::kStandardGravity_m_s2;
    root["world"]["ground"] = true;
  } else {
    root["world"] = full_path(world.sdf);
    for (const auto& folder : world.model_path) root["model_path"].push_back(folder.string());
    if (world.ignore_missing) root["missing"] = "ignore";
    if (world.applies_up_axis) root["collada_up_axis"] = "applied";
  }
  if (scenario.home) {
    root["home"]["lat_deg"] = scenario.home->lat_deg;
    root["home"]["lon_deg"] = scenario.home->lon_deg;
    root["home"]["alt_m"] = scenario.home->alt_m;
  }
  root["decimal_year"] = scenario.decimal_year;
  base::for_each_key(base::kWeatherKeys, [&](const auto& key) {
    if (const auto& value = key.of(scenario.weather))
      root["weather"][std::string(key.name)] = *value;
  });
}

YAML::Node vehicle_node(const ScenarioVehicle& vehicle) {
  YAML::Node node;
  node["name"] = vehicle.name;
  node["vehicle"] = full_path(vehicle.vehicle);
  node["pose"]["x_m"] = vehicle.pose.x_m;
  node["pose"]["y_m"] = vehicle.pose.y_m;
  if (vehicle.pose.z_m) node["pose"]["z_m"] = *vehicle.pose.z_m;
  node["pose"]["yaw_deg"] = vehicle.pose.yaw_deg;
  return node;
}

YAML::Node sensors_node(const Scenario& scenario, std::size_t vehicle) {
  const base::ConfigNode& set_or_keys = scenario.sensors_of(vehicle);
  YAML::Node node(YAML::NodeType::Map);
  if (set_or_keys.is_scalar()) {
    node["preset"] = set_or_keys.as<std::string>();
  } else {
    node = copy(set_or_keys);
  }
  if (node["preset"]) {
    const auto set = node["preset"].as<std::string>();
    const auto file = set_or_keys.resolve(set);
    const bool is_name = std::filesystem::path(set).extension().empty();
    if (!is_name && std::filesystem::is_regular_file(file)) node["preset"] = full_path(file);
  }
  node["imu"]["rate_hz"] = scenario.rates.sensor_hz;
  node["gps"]["rate_hz"] = scenario.rates.gps_hz;
  return node;
}

std::string sensors_origins(const std::string& path, const base::ConfigNode& set_or_keys) {
  return base::origin_notes(path + (set_or_keys.is_scalar() ? ".preset" : ""), set_or_keys);
}

}  // namespace cas::hils
