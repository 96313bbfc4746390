// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/controller_parts.hpp"

#include <yaml-cpp/yaml.h>

#include "base/config/config_origin.hpp"
#include "hils/scenario/simulation_parts.hpp"
#include "hils/scenario/yaml_text.hpp"

namespace cas::hils {

namespace {

/// Replaces keys of a map by those of another, block by block.
void overlay(YAML::Node node, const YAML::Node& own) {
  for (const auto& entry : own) {
    const auto key = entry.first.as<std::string>();
    if (entry.second.IsMap() && node[key] && node[key].IsMap()) {
      overlay(node[key], entry.second);
    } else {
      node[key] = entry.second;
    }
  }
}

}  // namespace

YAML::Node controller_node(const Scenario& scenario, std::size_t vehicle) {
  const ScenarioVehicle& own = scenario.vehicles.at(vehicle);
  YAML::Node root = copy(scenario.controller);
  overlay(root, copy(own.controller));
  root["schema"] = 1;
  root["vehicle"] = full_path(own.vehicle);
  if (scenario.flies_several()) root["system_id"] = static_cast<int>(own.system_id);
  if (!root["sensors"]) root["sensors"] = sensors_node(scenario, vehicle);
  root["decimal_year"] = scenario.decimal_year;
  root["control_rate_hz"] = scenario.rates.controls_hz;
  return root;
}

std::string controller_origins(const Scenario& scenario, std::size_t vehicle) {
  return sensors_origins("sensors", scenario.sensors_of(vehicle)) +
         base::origin_notes("", scenario.controller) +
         base::origin_notes("", scenario.vehicles.at(vehicle).controller);
}

}  // namespace cas::hils
