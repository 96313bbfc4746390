// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/composition.hpp"

#include <yaml-cpp/yaml.h>

#include <optional>

#include "base/os/write_file.hpp"
#include "base/random.hpp"
#include "fcu/line/line_model.hpp"
#include "hils/programs/yaml_text.hpp"

namespace cas::hils {

namespace {

constexpr double kGravity = 9.80665;  ///< standard gravity, m/s^2
constexpr double kTruthHz = 100;
constexpr int kLockstepTimeoutMs = 10'000;  ///< a controller that died, not a machine that is busy
constexpr int kSimulatorComponent = 200;    ///< the simulator beside autopilot 1 of its system

YAML::Node plugin(const char* name) {
  YAML::Node node(YAML::NodeType::Map);
  node["plugin"] = name;
  return node;
}

/// What `sensors` of simulator and controller alike says: the scenario's set at the scenario's
/// rates. A set in a file is named by its whole path, for the files made of it lie elsewhere.
YAML::Node sensors(const Scenario& scenario, std::size_t vehicle) {
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

YAML::Node interface_plugin(const Scenario& scenario, std::size_t vehicle, Transport transport,
                            const VehiclePlaces& places) {
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
  node["system_id"] = static_cast<int>(scenario.vehicles[vehicle].system_id);
  node["component_id"] = kSimulatorComponent;
  return node;
}

/// Plugin fault with what befalls the vehicle; nothing where that is nothing.
std::optional<YAML::Node> fault_plugin(const Scenario& scenario, std::size_t vehicle) {
  YAML::Node faults;
  for (const VehicleFault& fault : scenario.faults.vehicle) {
    if (fault.vehicle.value_or(vehicle) != vehicle) continue;
    faults.push_back(copy(fault.script));
    faults[faults.size() - 1].remove("vehicle");
  }
  if (faults.size() == 0) return std::nullopt;
  YAML::Node node = plugin("fault");
  node["faults"] = faults;
  return node;
}

YAML::Node vehicle_plugins(const Scenario& scenario, std::size_t vehicle, Transport transport,
                           const VehiclePlaces& places) {
  YAML::Node plugins;
  for (const char* name : {"motor", "imu", "gps", "magnetometer", "barometer"}) {
    plugins.push_back(plugin(name));
  }
  for (const base::ConfigNode& further : scenario.plugins) plugins.push_back(copy(further));
  if (const auto faults = fault_plugin(scenario, vehicle)) plugins.push_back(*faults);
  plugins.push_back(interface_plugin(scenario, vehicle, transport, places));
  YAML::Node recorder;
  recorder["plugin"] = "recorder";
  recorder["file"] = full_path(places.truth_csv());
  recorder["rate_hz"] = kTruthHz;
  plugins.push_back(recorder);
  return plugins;
}

bool has_line(Architecture architecture) { return architecture != Architecture::kSitl; }

YAML::Node line_node(const RunRequest& request) {
  if (!has_line(request.architecture)) return YAML::Node(YAML::NodeType::Map);
  YAML::Node node = copy(request.scenario.line);
  if (!request.line_preset.empty()) node["preset"] = request.line_preset;
  return node;
}

YAML::Node simulated_vehicle(const Scenario& scenario, std::size_t vehicle, Transport transport,
                             const VehiclePlaces& places) {
  const ScenarioVehicle& own = scenario.vehicles[vehicle];
  YAML::Node node;
  node["name"] = own.name;
  node["vehicle"] = full_path(own.vehicle);
  node["pose"]["x_m"] = own.pose.x_m;
  node["pose"]["y_m"] = own.pose.y_m;
  node["pose"]["z_m"] = 0;
  node["pose"]["yaw_deg"] = own.pose.yaw_deg;
  node["sensors"] = sensors(scenario, vehicle);
  node["plugins"] = vehicle_plugins(scenario, vehicle, transport, places);
  return node;
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
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    root["vehicles"].push_back(simulated_vehicle(scenario, i, transport, places.vehicles.at(i)));
  }
  return to_text(root);
}

std::string fcu_config(const RunRequest& request, std::size_t vehicle) {
  const Scenario& scenario = request.scenario;
  const ScenarioVehicle& own = scenario.vehicles.at(vehicle);
  YAML::Node root = copy(scenario.controller);
  overlay(root, copy(own.controller));
  root["schema"] = 1;
  root["vehicle"] = full_path(own.vehicle);
  if (scenario.flies_several()) root["system_id"] = static_cast<int>(own.system_id);
  if (!root["sensors"]) root["sensors"] = sensors(scenario, vehicle);
  root["decimal_year"] = scenario.decimal_year;
  root["control_rate_hz"] = scenario.rates.controls_hz;
  // Each line has its own misfortunes.
  root["seed"] = vehicle == 0 ? request.seed : base::derive_seed(request.seed, own.name);
  root["pace"] = pace_word(request);
  // In lockstep a line could only cost wall clock.
  if (!request.lockstep) root["line"] = line_node(request);
  return to_text(root);
}

fcu::LineConfig line_of(const RunRequest& request) {
  return fcu::LineConfig::parse(
      base::ConfigNode::parse(to_text(line_node(request)), request.scenario.file.string()));
}

void write_configs(const RunRequest& request, Transport transport, const RunPlaces& places) {
  std::filesystem::create_directories(places.run);
  base::write_file(places.simulator_config(), simulator_config(request, transport, places),
                   base::Durability::kCache);
  for (std::size_t i = 0; i < places.vehicles.size(); ++i) {
    base::write_file(places.vehicles[i].fcu_config(), fcu_config(request, i),
                     base::Durability::kCache);
  }
  base::write_file(places.casd_config(), casd_config(request, places), base::Durability::kCache);
}

}  // namespace cas::hils
