// SPDX-License-Identifier: BSD-3-Clause
#include "hils/composition.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <optional>

#include "base/install_paths.hpp"
#include "fcu/line_config.hpp"
#include "hils/report.hpp"

namespace cas::hils {

namespace {

constexpr double kGravity = 9.80665;  ///< standard gravity, m/s^2
constexpr double kNorthYawDeg = 90;   ///< W counts yaw from east, counter-clockwise
constexpr double kTruthHz = 100;
constexpr int kLockstepTimeoutMs = 10'000;  ///< a controller that died, not a machine that is busy
constexpr int kSimulatorComponent = 200;    ///< the simulator beside autopilot 1 of its system

/// The block as a node of its own; an empty map where there is none.
YAML::Node copy(const base::ConfigNode& node) {
  YAML::Node result = YAML::Load(node.dump());
  return result.IsMap() ? result : YAML::Node(YAML::NodeType::Map);
}

std::string to_text(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << node;
  return std::string(emitter.c_str()) + "\n";
}

std::string full_path(const std::filesystem::path& path) {
  return std::filesystem::weakly_canonical(path).string();
}

std::string local_port(std::uint16_t port) { return fmt::format("127.0.0.1:{}", port); }

YAML::Node plugin(const char* name) {
  YAML::Node node(YAML::NodeType::Map);
  node["plugin"] = name;
  return node;
}

/// What `sensors` of simulator and controller alike says: the scenario's set at the scenario's
/// rates. A set in a file is named by its whole path, for the files made of it lie elsewhere.
YAML::Node sensors(const Scenario& scenario) {
  YAML::Node node(YAML::NodeType::Map);
  if (scenario.sensors.is_scalar()) {
    node["preset"] = scenario.sensors.as<std::string>();
  } else {
    node = copy(scenario.sensors);
  }
  if (node["preset"]) {
    const auto set = node["preset"].as<std::string>();
    const auto file = scenario.sensors.resolve(set);
    const bool is_name = std::filesystem::path(set).extension().empty();
    if (!is_name && std::filesystem::is_regular_file(file)) node["preset"] = full_path(file);
  }
  node["imu"]["rate_hz"] = scenario.rates.sensor_hz;
  node["gps"]["rate_hz"] = scenario.rates.gps_hz;
  return node;
}

const char* pace_word(const RunRequest& request) {
  return request.lockstep ? "lockstep" : "realtime";
}

YAML::Node interface_plugin(const Scenario& scenario, Transport transport,
                            const RunPlaces& places) {
  YAML::Node node;
  node["plugin"] = "mavlink_interface";
  node["control_rate_hz"] = scenario.rates.controls_hz;
  if (transport == Transport::kBus) {
    node["transport"] = "bus";
  } else {
    node["transport"] = "udp";
    node["local"] = local_port(places.simulator_port);
    node["remote"] = local_port(places.casd_port);
    node["ledger"] = full_path(places.simulator_ledger());
  }
  node["system_id"] = 1;
  node["component_id"] = kSimulatorComponent;
  return node;
}

YAML::Node fault_plugin(const Scenario& scenario) {
  YAML::Node node(YAML::NodeType::Map);
  node["plugin"] = "fault";
  for (const base::ConfigNode& fault : scenario.faults.vehicle) {
    node["faults"].push_back(copy(fault));
  }
  return node;
}

YAML::Node vehicle_plugins(const Scenario& scenario, Transport transport, const RunPlaces& places) {
  YAML::Node plugins;
  for (const char* name : {"motor", "imu", "gps", "magnetometer", "barometer"}) {
    plugins.push_back(plugin(name));
  }
  for (const base::ConfigNode& further : scenario.plugins) plugins.push_back(copy(further));
  if (!scenario.faults.vehicle.empty()) plugins.push_back(fault_plugin(scenario));
  plugins.push_back(interface_plugin(scenario, transport, places));
  YAML::Node recorder;
  recorder["plugin"] = "recorder";
  recorder["file"] = full_path(places.truth_csv());
  recorder["rate_hz"] = kTruthHz;
  plugins.push_back(recorder);
  return plugins;
}

YAML::Node list(std::initializer_list<const char*> names) {
  YAML::Node node;
  for (const char* name : names) node.push_back(name);
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

YAML::Node route(const char* from, const char* to) {
  YAML::Node node;
  node["from"] = from;
  node["to"] = to;
  return node;
}

bool has_line(Architecture architecture) { return architecture != Architecture::kSitl; }

std::string_view threads(Architecture architecture) {
  if (architecture == Architecture::kTs) return "blocking";
  if (architecture == Architecture::kLoop) return "single";
  return "per_link";
}

YAML::Node line_node(const RunRequest& request) {
  if (!has_line(request.architecture)) return YAML::Node(YAML::NodeType::Map);
  YAML::Node node = copy(request.scenario.line);
  if (!request.line_preset.empty()) node["preset"] = request.line_preset;
  return node;
}

/// The rate that casd is told: none for USB, which has no bit rate that a sender could keep to.
int serial_baud(const RunRequest& request) {
  if (!request.fcu_device.empty()) return static_cast<int>(request.fcu_baud);
  if (request.lockstep) return 0;
  const fcu::LineConfig line = line_of(request);
  return line.batch > base::Duration::zero() ? 0 : static_cast<int>(line.baud);
}

YAML::Node casd_links(const RunRequest& request, const RunPlaces& places) {
  YAML::Node links;
  YAML::Node simulator;
  simulator["name"] = "sim";
  simulator["type"] = "udp";
  simulator["local"] = local_port(places.casd_port);
  simulator["remote"] = local_port(places.simulator_port);
  links.push_back(simulator);
  YAML::Node controller;
  controller["name"] = "fcu";
  controller["type"] = "serial";
  controller["device"] =
      request.fcu_device.empty() ? places.fcu_link().string() : request.fcu_device;
  controller["baud"] = serial_baud(request);
  links.push_back(controller);
  if (places.ground_station_port == 0) return links;
  YAML::Node ground_station;
  ground_station["name"] = "gcs";
  ground_station["type"] = "udp";
  ground_station["remote"] = local_port(places.ground_station_port);
  links.push_back(ground_station);
  return links;
}

/// The traditional set-up forwards everything to everybody.
YAML::Node routes_without_filter(const RunPlaces& places) {
  YAML::Node routes;
  std::vector<const char*> names{"sim", "fcu"};
  if (places.ground_station_port != 0) names.push_back("gcs");
  for (const char* from : names) {
    for (const char* to : names) {
      if (from != to) routes.push_back(route(from, to));
    }
  }
  return routes;
}

YAML::Node casd_routes(Architecture architecture, const RunPlaces& places) {
  if (architecture == Architecture::kTs) return routes_without_filter(places);
  YAML::Node to_controller = route("sim", "fcu");
  to_controller["allow"] = list({"HEARTBEAT", "HIL_SENSOR", "HIL_GPS"});
  YAML::Node to_simulator = route("fcu", "sim");
  to_simulator["allow"] = list({"HEARTBEAT", "HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"});
  YAML::Node routes;
  routes.push_back(to_controller);
  routes.push_back(to_simulator);
  if (places.ground_station_port == 0) return routes;
  YAML::Node to_ground = route("fcu", "gcs");
  to_ground["block"] = list({"HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"});
  routes.push_back(to_ground);
  routes.push_back(route("gcs", "fcu"));
  return routes;
}

}  // namespace

std::string simulator_config(const RunRequest& request, Transport transport,
                             const RunPlaces& places) {
  const Scenario& scenario = request.scenario;
  YAML::Node root;
  root["schema"] = 1;
  root["world"]["gravity_m_s2"] = kGravity;
  root["world"]["ground"] = true;
  root["home"]["lat_deg"] = scenario.home.lat_deg;
  root["home"]["lon_deg"] = scenario.home.lon_deg;
  root["home"]["alt_m"] = scenario.home.alt_m;
  root["decimal_year"] = scenario.decimal_year;
  root["step_us"] = scenario.step_us;
  root["pace"] = transport == Transport::kBus ? "free_run" : pace_word(request);
  if (request.lockstep) root["pacing"]["lockstep_timeout_ms"] = kLockstepTimeoutMs;
  root["seed"] = request.seed;
  root["integrator"] = scenario.integrator;
  YAML::Node vehicle;
  vehicle["name"] = kVehicleName;
  vehicle["vehicle"] = full_path(scenario.vehicle);
  vehicle["pose"]["x_m"] = 0;
  vehicle["pose"]["y_m"] = 0;
  vehicle["pose"]["z_m"] = 0;
  vehicle["pose"]["yaw_deg"] = kNorthYawDeg;
  vehicle["sensors"] = sensors(scenario);
  vehicle["plugins"] = vehicle_plugins(scenario, transport, places);
  root["vehicles"].push_back(vehicle);
  return to_text(root);
}

std::string fcu_config(const RunRequest& request) {
  const Scenario& scenario = request.scenario;
  YAML::Node root = copy(scenario.controller);
  root["schema"] = 1;
  root["vehicle"] = full_path(scenario.vehicle);
  if (!root["sensors"]) root["sensors"] = sensors(scenario);
  root["decimal_year"] = scenario.decimal_year;
  root["control_rate_hz"] = scenario.rates.controls_hz;
  root["seed"] = request.seed;
  root["pace"] = pace_word(request);
  // In lockstep a line could only cost wall clock.
  if (!request.lockstep) root["line"] = line_node(request);
  return to_text(root);
}

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

fcu::LineConfig line_of(const RunRequest& request) {
  return fcu::LineConfig::parse(
      base::ConfigNode::parse(to_text(line_node(request)), request.scenario.file.string()));
}

void write_configs(const RunRequest& request, Transport transport, const RunPlaces& places) {
  std::filesystem::create_directories(places.run);
  write_text(places.simulator_config(), simulator_config(request, transport, places));
  write_text(places.fcu_config(), fcu_config(request));
  write_text(places.casd_config(), casd_config(request, places));
}

}  // namespace cas::hils
