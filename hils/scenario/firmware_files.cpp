// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/firmware_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "base/config/install_paths.hpp"
#include "hils/scenario/simulation_parts.hpp"

namespace cas::hils {

namespace {

base::ConfigNode node_of(const YAML::Node& root, const Scenario& scenario, const char* what) {
  return base::ConfigNode::parse(YAML::Dump(root),
                                 fmt::format("{} ({})", scenario.file.string(), what));
}

/// How the simulator's time goes on, by who waits for whom.
void put_pace(const Firmware& firmware, YAML::Node& root) {
  if (firmware.on_serial_line) {
    // PX4 stamps each sample when it arrives: samples come evenly, never in a burst.
    root["pace"] = "realtime";
    root["pacing"] = YAML::Load("{largest_burst_ms: 1, catch_up_rate: 1.1, max_lag_ms: 50}");
    return;
  }
  root["pace"] = "lockstep";
  root["pacing"]["lockstep_timeout_ms"] = 1000;
  if (firmware.autopilot == "PX4") {
    root["speed"] = 1;
  } else {
    root["step_us"] = 833.333333;  // ArduPilot asks for 1200 steps a second, and keeps the pace
  }
}

YAML::Node interface_plugin(const Firmware& firmware, std::size_t instance) {
  constexpr std::size_t kFirstJsonPort = 9002;
  if (firmware.on_serial_line) {
    return YAML::Load(
        "{plugin: mavlink_interface, transport: udp, local: '127.0.0.1:14560', "
        "remote: '127.0.0.1:14561'}");
  }
  if (firmware.autopilot == "PX4") {
    return YAML::Load(
        fmt::format("{{plugin: mavlink_interface, transport: tcp_server, system_id: {}, "
                    "instance: {}}}",
                    system_of_instance(instance), instance));
  }
  return YAML::Load(fmt::format("{{plugin: ardupilot_json, local: '127.0.0.1:{}'}}",
                                kFirstJsonPort + 10 * instance));
}

/// ArduPilot makes compass, barometer, GPS and their noise itself, from the true motion.
YAML::Node plugins(const ScenarioVehicle& vehicle, const Firmware& firmware, std::size_t instance) {
  YAML::Node list;
  const auto& set = vehicle.sensors ? vehicle.sensors : firmware.sensors;
  const std::vector<std::string> names =
      firmware.autopilot == "PX4"
          ? first_plugins(vehicle.vehicle,
                          flown_sensors(vehicle.vehicle, set ? *set : base::ConfigNode::empty()))
          : first_forces(vehicle.vehicle);
  for (const std::string& name : names) list.push_back(named_plugin(name));
  list.push_back(interface_plugin(firmware, instance));
  return list;
}

constexpr const char* kLinksInSoftware = R"([
  {{name: {0}, type: udp_server, local: '127.0.0.1:14550'}},
  {{name: gcs, type: udp_server, local: '127.0.0.1:14551',
    accept: {{traffic: ground_station, block_systems: [{1}]}}}}])";

constexpr const char* kLinksOfABoard = R"([
  {name: sim, type: udp, local: '127.0.0.1:14561', remote: '127.0.0.1:14560'},
  {name: fcu, type: serial, device: /dev/pixhawk, sensor_gap_ms: 1.5},
  {name: gcs, type: udp, remote: '127.0.0.1:14550',
    accept: {traffic: ground_station, block_systems: [1]}}])";

constexpr const char* kRoutesOfABoard = R"([
  {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]},
  {from: fcu, to: sim, allow: [HEARTBEAT, HIL_CONTROLS, HIL_ACTUATOR_CONTROLS]},
  {from: fcu, to: gcs, block: [HIL_CONTROLS, HIL_ACTUATOR_CONTROLS]},
  {from: gcs, to: fcu}])";

}  // namespace

base::ConfigNode firmware_world(const Scenario& scenario, const Firmware& firmware) {
  YAML::Node root;
  root["schema"] = 1;
  put_world(scenario, root);
  root["step_us"] = scenario.step_us;
  put_pace(firmware, root);
  root["seed"] = scenario.seed;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    YAML::Node vehicle = vehicle_node(scenario.vehicles[i]);
    vehicle["plugins"] = plugins(scenario.vehicles[i], firmware, i);
    root["vehicles"].push_back(vehicle);
  }
  return node_of(root, scenario, "world");
}

base::ConfigNode firmware_topology(const Scenario& scenario, const Firmware& firmware) {
  YAML::Node root;
  root["schema"] = 1;
  root["command_port"]["port"] = 0;
  root["commanding"]["heartbeat_hz"] = 1;  // without one PX4 counts its ground station as lost
  root["commanding"]["allow_not_hil"] = firmware.not_hil && !firmware.on_serial_line;
  if (firmware.on_serial_line) {
    root["links"] = YAML::Load(kLinksOfABoard);
    root["routes"] = YAML::Load(kRoutesOfABoard);
  } else {
    root["links"] = YAML::Load(fmt::format(fmt::runtime(kLinksInSoftware),
                                           firmware.autopilot == "PX4" ? "px4" : "ardupilot",
                                           fmt::join(scenario.systems(), ", ")));
  }
  root["gains"] = base::shipped_config("gains.yaml").string();
  return node_of(root, scenario, "topology");
}

}  // namespace cas::hils
