// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/simulation_parts.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/config/config_origin.hpp"
#include "base/config/sensor_names.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/weather_keys.hpp"
#include "base/earth/gravity.hpp"
#include "hils/scenario/yaml_text.hpp"

namespace cas::hils {

base::ConfigNode flown_sensors(const std::filesystem::path& vehicle,
                               const base::ConfigNode& set_or_keys) {
  const auto own = base::ConfigNode::load(vehicle).find("sensors");
  const base::ConfigNode behind = own ? base::sensor_set(*own) : base::ConfigNode::empty();
  return set_or_keys.is_null() ? behind : base::sensor_set(set_or_keys, behind);
}

base::ConfigNode flown_sensors(const Scenario& scenario, std::size_t vehicle) {
  return flown_sensors(scenario.vehicles.at(vehicle).vehicle, scenario.sensors_of(vehicle));
}

std::vector<std::string> further_first_sensors(const base::ConfigNode& set) {
  std::vector<std::string> names = base::further_sensors(set);
  std::erase_if(names, [](const std::string& name) {
    const auto sensor = base::parse_sensor_name(name);
    return std::ranges::find(kFirstPlugins, sensor->plugin) == kFirstPlugins.end();
  });
  return names;
}

std::vector<std::string> first_forces(const std::filesystem::path& vehicle) {
  std::vector<std::string> names{kFirstPlugins.front()};
  if (base::ConfigNode::load(vehicle).has(kAeroPlugin)) names.emplace_back(kAeroPlugin);
  return names;
}

std::vector<std::string> first_plugins(const std::filesystem::path& vehicle,
                                       const base::ConfigNode& set) {
  std::vector<std::string> names = first_forces(vehicle);
  names.insert(names.end(), kFirstPlugins.begin() + 1, kFirstPlugins.end());
  for (std::string& name : further_first_sensors(set)) names.push_back(std::move(name));
  return names;
}

YAML::Node named_plugin(const std::string& name) {
  YAML::Node node;
  const auto sensor = base::parse_sensor_name(name);
  node["plugin"] = sensor ? std::string(sensor->plugin) : name;
  if (sensor && sensor->number > 1) node["number"] = sensor->number;
  return node;
}

void put_world(const Scenario& scenario, YAML::Node& root) {
  const ScenarioWorld& world = scenario.world;
  if (world.sdf.empty()) {
    root["world"]["gravity_m_s2"] = base::kStandardGravity_m_s2;
    root["world"]["ground"] = !world.terrain;
  } else {
    root["world"] = full_path(world.sdf);
    for (const auto& folder : world.model_path) root["model_path"].push_back(folder.string());
    if (world.ignore_missing) root["missing"] = "ignore";
    if (world.applies_up_axis) root["collada_up_axis"] = "applied";
  }
  if (world.terrain) {
    for (const auto& file : world.terrain->files) {
      root["terrain"]["files"].push_back(file.string());
    }
    if (!world.terrain->geoid.empty()) {
      root["terrain"]["geoid"] = std::filesystem::weakly_canonical(world.terrain->geoid).string();
    }
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
  for (const std::string& name : base::further_sensors(flown_sensors(scenario, vehicle))) {
    const std::string_view plugin = base::parse_sensor_name(name)->plugin;
    if (plugin == "imu") node[name]["rate_hz"] = scenario.rates.sensor_hz;
    if (plugin == "gps") node[name]["rate_hz"] = scenario.rates.gps_hz;
  }
  return node;
}

std::string sensors_origins(const std::string& path, const base::ConfigNode& set_or_keys) {
  return base::origin_notes(path + (set_or_keys.is_scalar() ? ".preset" : ""), set_or_keys);
}

}  // namespace cas::hils
