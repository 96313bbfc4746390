// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/composition.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config_origin.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/vehicle.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/random.hpp"
#include "casd/packet/own_station.hpp"
#include "fcu/line/line_model.hpp"
#include "hils/programs/composed_parts.hpp"
#include "hils/scenario/controller_parts.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/scenario/simulation_parts.hpp"
#include "libsim/core/run/plugin_loader.hpp"
#include "plugins/common/plugin_messages.hpp"

namespace cas::hils {

namespace {

/// What the plugin of a key declares. @throws base::ConfigError at the key
std::vector<std::string> words_of(sim::PluginLoader& loader, const base::ConfigNode& key) {
  try {
    return loader.sends(key.as<std::string>());
  } catch (const base::ConfigError& error) {
    key.fail(error.what());
  }
}

/// Names of the MAVLink messages that a vehicle's simulator sends beside those of every run, each
/// once: BATTERY_STATUS where its file has a battery, ESC_STATUS and ESC_INFO where its motors are
/// circuits, then the declarations of the scenario's further plugins (CAS_PLUGIN_SENDS), in their
/// order. Opens their libraries, where the simulator will find them.
/// @throws base::ConfigError with file and line, for a plugin that is not there or that declares a
/// message it may not send
std::vector<std::string> declared_messages(const Scenario& scenario, std::size_t vehicle) {
  std::vector<std::string> names;
  const auto file = base::ConfigNode::load(scenario.vehicles.at(vehicle).vehicle);
  if (file.has("battery")) names.emplace_back("BATTERY_STATUS");
  const auto is_electric = [](const base::Rotor& rotor) { return rotor.electric.has_value(); };
  if (std::ranges::any_of(base::Vehicle::load(scenario.vehicles[vehicle].vehicle).rotors,
                          is_electric)) {
    names.insert(names.end(), {"ESC_STATUS", "ESC_INFO"});
  }
  sim::PluginLoader loader({});
  for (const base::ConfigNode& further : scenario.plugins) {
    const base::ConfigNode key = further.at("plugin");
    for (const std::string& word : words_of(loader, key)) {
      try {
        const std::string name(sim::declared_message(word).name);
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
      } catch (const base::ConfigError& error) {
        key.fail("plugin " + key.as<std::string>() + " " + error.what());
      }
    }
  }
  return names;
}

std::string local_port(std::uint16_t port) { return fmt::format("127.0.0.1:{}", port); }

bool in_lockstep(const RunRequest& request) { return request.clock == Clock::kLockstep; }

const char* pace_word(const RunRequest& request) {
  return in_lockstep(request) ? "lockstep" : "realtime";
}

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

/// Key `baud` of casd's serial link; 0 for USB, which has no bit rate to pace by.
int serial_baud(const RunRequest& request, const FcuDevice* device) {
  if (device != nullptr) return static_cast<int>(device->baud);
  if (in_lockstep(request)) return 0;
  const fcu::LineConfig line = line_of(request);
  return line.batch > base::Duration::zero() ? 0 : static_cast<int>(line.baud);
}

void add_vehicle_links(const RunRequest& request, std::size_t vehicle, const VehiclePaths& paths,
                       YAML::Node& links) {
  YAML::Node simulator;
  simulator["name"] = paths.simulator_link;
  simulator["type"] = "udp";
  simulator["local"] = local_port(paths.casd_port);
  simulator["remote"] = local_port(paths.simulator_port);
  links.push_back(simulator);
  YAML::Node controller;
  controller["name"] = paths.controller_link;
  controller["type"] = "serial";
  const FcuDevice* device = request.fcu_device(vehicle);
  controller["device"] = device == nullptr ? paths.fcu_link().string() : device->path;
  controller["baud"] = serial_baud(request, device);
  // A device named by the user is meant; casd still refuses the terminal of a session.
  if (device != nullptr) controller["unlocked_pty"] = true;
  links.push_back(controller);
}

YAML::Node casd_links(const RunRequest& request, const RunPaths& paths) {
  YAML::Node links;
  for (std::size_t i = 0; i < paths.vehicles.size(); ++i) {
    add_vehicle_links(request, i, paths.vehicles[i], links);
  }
  if (paths.ground_station_port != 0) {
    const StationEndpoint own{.type = "udp", .address = local_port(paths.ground_station_port)};
    links.push_back(ground_link(request, kGroundLink, own));
  }
  if (request.station) {
    links.push_back(ground_link(request, kStationLink, *request.station));
  }
  return links;
}

/// The traditional set-up forwards every packet to every other link of the same vehicle.
void add_routes_without_filter(const VehiclePaths& paths, bool ground, YAML::Node& routes) {
  std::vector<std::string> names{paths.simulator_link, paths.controller_link};
  if (ground) names.push_back(kGroundLink);
  for (const std::string& from : names) {
    for (const std::string& to : names) {
      if (from != to) routes.push_back(route(from, to));
    }
  }
}

void add_ground_routes(const VehiclePaths& paths, const std::string& link, YAML::Node& routes) {
  YAML::Node to_ground = route(paths.controller_link, link);
  to_ground["block"] = list({"HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"});
  routes.push_back(to_ground);
  routes.push_back(route(link, paths.controller_link));
}

/// @param declared  messages of plugins that pass to the controller, too
void add_routes(const VehiclePaths& paths, bool ground, const std::vector<std::string>& declared,
                YAML::Node& routes) {
  YAML::Node to_controller = route(paths.simulator_link, paths.controller_link);
  to_controller["allow"] = list({"HEARTBEAT", "HIL_SENSOR", "HIL_GPS"});
  for (const std::string& message : declared) to_controller["allow"].push_back(message);
  YAML::Node to_simulator = route(paths.controller_link, paths.simulator_link);
  to_simulator["allow"] = list({"HEARTBEAT", "HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"});
  routes.push_back(to_controller);
  routes.push_back(to_simulator);
  if (ground) add_ground_routes(paths, kGroundLink, routes);
}

/// No packet of one vehicle goes to another. A station that joins gets the same from every
/// architecture.
YAML::Node casd_routes(const RunRequest& request, const RunPaths& paths) {
  const bool ground = paths.ground_station_port != 0;
  YAML::Node routes;
  for (std::size_t i = 0; i < paths.vehicles.size(); ++i) {
    const VehiclePaths& vehicle = paths.vehicles[i];
    request.architecture == Architecture::kTs
        ? add_routes_without_filter(vehicle, ground, routes)
        : add_routes(vehicle, ground, declared_messages(request.scenario, i), routes);
    if (request.station) add_ground_routes(vehicle, kStationLink, routes);
  }
  return routes;
}

constexpr int kLockstepTimeoutMs = 10'000;  ///< a controller that died, not a machine that is busy
constexpr int kSimulatorComponent = 200;    ///< the simulator beside autopilot 1 of its system

YAML::Node interface_plugin(const Scenario& scenario, std::size_t vehicle, Transport transport,
                            const VehiclePaths& paths) {
  YAML::Node node;
  node["plugin"] = "mavlink_interface";
  node["control_rate_hz"] = scenario.rates.controls_hz;
  if (transport == Transport::kBus) {
    node["transport"] = "bus";
  } else {
    node["transport"] = "udp";
    node["local"] = local_port(paths.simulator_port);
    node["remote"] = local_port(paths.casd_port);
    node["ledger"] = below_out(paths, paths.simulator_ledger());
  }
  node["system_id"] = static_cast<int>(scenario.vehicles[vehicle].system_id);
  node["component_id"] = kSimulatorComponent;
  return node;
}

/// Where values of a vehicle came from, for errors of plugins (base/config/config_origin.hpp).
std::string vehicle_origins(const Scenario& scenario, std::size_t vehicle) {
  const std::string where = fmt::format("vehicles[{}].", vehicle);
  const std::size_t first =
      first_plugins(scenario.vehicles[vehicle].vehicle, flown_sensors(scenario, vehicle)).size();
  return sensors_origins(where + "sensors", scenario.sensors_of(vehicle)) +
         plugin_origins(scenario, vehicle, first);
}

YAML::Node vehicle_plugins(const RunRequest& request, std::size_t vehicle, Transport transport,
                           const VehiclePaths& paths) {
  YAML::Node plugins;
  const Scenario& scenario = request.scenario;
  for (const std::string& name :
       first_plugins(scenario.vehicles[vehicle].vehicle, flown_sensors(scenario, vehicle))) {
    plugins.push_back(named_plugin(name));
  }
  add_scenario_plugins(request, vehicle, plugins);
  plugins.push_back(interface_plugin(scenario, vehicle, transport, paths));
  plugins.push_back(recorder_plugin(request, paths));
  return plugins;
}

bool has_line(Architecture architecture) { return architecture != Architecture::kSitl; }

YAML::Node line_node(const RunRequest& request) {
  if (!has_line(request.architecture)) return YAML::Node(YAML::NodeType::Map);
  YAML::Node node = copy(request.scenario.line);
  if (!request.line_preset.empty()) node["preset"] = request.line_preset;
  return node;
}

YAML::Node simulated_vehicle(const RunRequest& request, std::size_t vehicle, Transport transport,
                             const VehiclePaths& paths) {
  const Scenario& scenario = request.scenario;
  YAML::Node node = vehicle_node(scenario.vehicles[vehicle]);
  node["sensors"] = sensors_node(scenario, vehicle);
  node["plugins"] = vehicle_plugins(request, vehicle, transport, paths);
  return node;
}

}  // namespace

std::string casd_config(const RunRequest& request, const RunPaths& paths) {
  YAML::Node root;
  root["schema"] = 1;
  root["system_id"] = static_cast<int>(casd::kOwnStation.system);
  root["component_id"] = static_cast<int>(casd::kOwnStation.component);
  root["pace"] = pace_word(request);
  root["threads"] = std::string(threads(request.architecture));
  root["drain_tick_ms"] = request.scenario.drain_tick_ms;
  root["command_port"]["address"] = "127.0.0.1";
  root["command_port"]["port"] = 0;
  root["command_port"]["unix"] = paths.command_port.string();
  root["command_port"]["token_file"] = paths.command_token().string();
  root["links"] = casd_links(request, paths);
  root["routes"] = casd_routes(request, paths);
  root["commanding"]["heartbeat_hz"] = 1;
  root["gains"] = full_path(base::shipped_config("gains.yaml"));
  root["log"]["folder"] = full_path(paths.out);
  root["log"]["tlog"] = paths.flight_tlog().filename().string();
  root["log"]["overwrite"] = true;
  root["log"]["keep"]["free_space_min_mib"] = 0;  // half a log is no use to a run
  return to_text(root);
}

std::string simulator_config(const RunRequest& request, Transport transport,
                             const RunPaths& paths) {
  const Scenario& scenario = request.scenario;
  YAML::Node root;
  root["schema"] = 1;
  put_world(scenario, root);
  root["step_us"] = scenario.step_us;
  root["pace"] = transport == Transport::kBus ? "free_run" : pace_word(request);
  // A world's own real-time factor is no part of an experiment.
  if (transport == Transport::kUdp && !in_lockstep(request)) root["speed"] = 1;
  if (in_lockstep(request)) root["pacing"]["lockstep_timeout_ms"] = kLockstepTimeoutMs;
  root["seed"] = request.seed;
  root["integrator"] = scenario.integrator;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    root["vehicles"].push_back(simulated_vehicle(request, i, transport, paths.vehicles.at(i)));
  }
  std::string text = to_text(root);
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) text += vehicle_origins(scenario, i);
  return text;
}

std::string fcu_config(const RunRequest& request, std::size_t vehicle) {
  const Scenario& scenario = request.scenario;
  const ScenarioVehicle& own = scenario.vehicles.at(vehicle);
  YAML::Node root = controller_node(scenario, vehicle);
  // Each vehicle's line draws its own errors.
  root["seed"] = vehicle == 0 ? request.seed : base::derive_seed(request.seed, own.name);
  root["pace"] = pace_word(request);
  // In lockstep an emulated line would only cost wall-clock time.
  if (!in_lockstep(request)) root["line"] = line_node(request);
  std::string text = to_text(root) + controller_origins(scenario, vehicle);
  if (!in_lockstep(request)) text += base::origin_notes("line", scenario.line);
  return text;
}

fcu::LineConfig line_of(const RunRequest& request) {
  YAML::Node root;
  root["line"] = line_node(request);
  const std::string text = to_text(root) + base::origin_notes("line", request.scenario.line);
  return fcu::LineConfig::parse(
      base::ConfigNode::parse(text, request.scenario.file.string()).at("line"));
}

void write_configs(const RunRequest& request, Transport transport, const RunPaths& paths) {
  if (request.scenario.firmware) {
    throw base::ConfigError(request.scenario.file.string() +
                            ": stock firmware flies this scenario: take `hils run`, `compare`, "
                            "`sweep` or `campaign`, without --fcu");
  }
  base::make_result_folder({paths.out, paths.run});
  base::remove_result({paths.out, paths.plugin_figures()});  // of an earlier run in this folder
  const auto write = [&paths](const std::filesystem::path& file, const std::string& text) {
    base::write_result({paths.out, file}, text);
  };
  write(paths.simulator_config(), simulator_config(request, transport, paths));
  for (std::size_t i = 0; i < paths.vehicles.size(); ++i) {
    write(paths.vehicles[i].fcu_config(), fcu_config(request, i));
  }
  write(paths.casd_config(), casd_config(request, paths));
}

}  // namespace cas::hils
