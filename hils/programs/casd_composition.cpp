// SPDX-License-Identifier: BSD-3-Clause
#include <yaml-cpp/yaml.h>

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/install_paths.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/yaml_text.hpp"

namespace cas::hils {

namespace {

constexpr const char* kGroundLink = "gcs";

YAML::Node list(std::initializer_list<const char*> names) {
  YAML::Node node;
  for (const char* name : names) node.push_back(name);
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

YAML::Node route(const std::string& from, const std::string& to) {
  YAML::Node node;
  node["from"] = from;
  node["to"] = to;
  return node;
}

std::string_view threads(Architecture architecture) {
  if (architecture == Architecture::kTs) return "blocking";
  if (architecture == Architecture::kLoop) return "single";
  return "per_link";
}

/// The rate that casd is told: none for USB, which has no bit rate that a sender could keep to.
int serial_baud(const RunRequest& request) {
  if (!request.fcu_device.empty()) return static_cast<int>(request.fcu_baud);
  if (request.lockstep) return 0;
  const fcu::LineConfig line = line_of(request);
  return line.batch > base::Duration::zero() ? 0 : static_cast<int>(line.baud);
}

void add_vehicle_links(const RunRequest& request, const VehiclePlaces& places, YAML::Node& links) {
  YAML::Node simulator;
  simulator["name"] = places.simulator_link;
  simulator["type"] = "udp";
  simulator["local"] = local_port(places.casd_port);
  simulator["remote"] = local_port(places.simulator_port);
  links.push_back(simulator);
  YAML::Node controller;
  controller["name"] = places.controller_link;
  controller["type"] = "serial";
  controller["device"] =
      request.fcu_device.empty() ? places.fcu_link().string() : request.fcu_device;
  controller["baud"] = serial_baud(request);
  links.push_back(controller);
}

YAML::Node casd_links(const RunRequest& request, const RunPlaces& places) {
  YAML::Node links;
  for (const VehiclePlaces& vehicle : places.vehicles) add_vehicle_links(request, vehicle, links);
  if (places.ground_station_port == 0) return links;
  YAML::Node ground_station;
  ground_station["name"] = kGroundLink;
  ground_station["type"] = "udp";
  ground_station["remote"] = local_port(places.ground_station_port);
  links.push_back(ground_station);
  return links;
}

/// The traditional set-up forwards everything to everybody; a vehicle's links are one such set-up.
void add_routes_without_filter(const VehiclePlaces& places, bool ground, YAML::Node& routes) {
  std::vector<std::string> names{places.simulator_link, places.controller_link};
  if (ground) names.push_back(kGroundLink);
  for (const std::string& from : names) {
    for (const std::string& to : names) {
      if (from != to) routes.push_back(route(from, to));
    }
  }
}

void add_routes(const VehiclePlaces& places, bool ground, YAML::Node& routes) {
  YAML::Node to_controller = route(places.simulator_link, places.controller_link);
  to_controller["allow"] = list({"HEARTBEAT", "HIL_SENSOR", "HIL_GPS"});
  YAML::Node to_simulator = route(places.controller_link, places.simulator_link);
  to_simulator["allow"] = list({"HEARTBEAT", "HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"});
  routes.push_back(to_controller);
  routes.push_back(to_simulator);
  if (!ground) return;
  YAML::Node to_ground = route(places.controller_link, kGroundLink);
  to_ground["block"] = list({"HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"});
  routes.push_back(to_ground);
  routes.push_back(route(kGroundLink, places.controller_link));
}

/// No packet of one vehicle goes to another.
YAML::Node casd_routes(Architecture architecture, const RunPlaces& places) {
  const bool ground = places.ground_station_port != 0;
  YAML::Node routes;
  for (const VehiclePlaces& vehicle : places.vehicles) {
    architecture == Architecture::kTs ? add_routes_without_filter(vehicle, ground, routes)
                                      : add_routes(vehicle, ground, routes);
  }
  return routes;
}

}  // namespace

std::string casd_config(const RunRequest& request, const RunPlaces& places) {
  YAML::Node root;
  root["schema"] = 1;
  root["system_id"] = 254;
  root["component_id"] = 190;
  root["pace"] = pace_word(request);
  root["threads"] = std::string(threads(request.architecture));
  root["drain_tick_ms"] = request.scenario.drain_tick_ms;
  root["command_port"]["address"] = "127.0.0.1";
  root["command_port"]["port"] = 0;
  root["command_port"]["unix"] = places.command_port().string();
  root["links"] = casd_links(request, places);
  root["routes"] = casd_routes(request.architecture, places);
  root["commanding"]["heartbeat_hz"] = 1;
  root["gains"] = full_path(base::find_config("gains.yaml"));
  root["log"]["tlog"] = full_path(places.flight_tlog());
  root["log"]["overwrite"] = true;
  return to_text(root);
}

}  // namespace cas::hils
