// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/simulation_parts.hpp"

#include <yaml-cpp/yaml.h>

#include "base/earth/gravity.hpp"

namespace cas::hils {

void put_world(const Scenario& scenario, YAML::Node& root) {
  const ScenarioWorld& world = scenario.world;
  if (world.sdf.empty()) {
    root["world"]["gravity_m_s2"] = base::kStandardGravity_m_s2;
    root["world"]["ground"] = true;
  } else {
    root["world"] = std::filesystem::weakly_canonical(world.sdf).string();
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
}

YAML::Node vehicle_node(const ScenarioVehicle& vehicle) {
  YAML::Node node;
  node["name"] = vehicle.name;
  node["vehicle"] = std::filesystem::weakly_canonical(vehicle.vehicle).string();
  node["pose"]["x_m"] = vehicle.pose.x_m;
  node["pose"]["y_m"] = vehicle.pose.y_m;
  if (vehicle.pose.z_m) node["pose"]["z_m"] = *vehicle.pose.z_m;
  node["pose"]["yaw_deg"] = vehicle.pose.yaw_deg;
  return node;
}

}  // namespace cas::hils
