// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_composition.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "base/config/config_origin.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/firmware/companion_flight.hpp"
#include "hils/programs/composed_parts.hpp"
#include "hils/programs/fcu_device.hpp"
#include "hils/scenario/simulation_parts.hpp"

namespace cas::hils {

namespace {

/// Full path of the file that a key names, because the generated file lies elsewhere.
std::string full_path(const base::ConfigNode& key) {
  return std::filesystem::weakly_canonical(base::find_config(key)).string();
}

/// Names files of the world by their whole paths.
void resolve_files(const base::ConfigNode& source, YAML::Node world) {
  const auto scene = source.at("world");
  if (scene.is_scalar()) world["world"] = full_path(scene);
  const auto beside = [](const base::ConfigNode& key) {
    return std::filesystem::weakly_canonical(key.resolve(key.as<std::string>())).string();
  };
  if (const auto folders = source.find("model_path")) {
    const auto items = folders->items();
    for (std::size_t i = 0; i < items.size(); ++i) world["model_path"][i] = beside(items[i]);
  }
  if (const auto terrain = source.find("terrain")) {
    const auto files = terrain->at("files").items();
    for (std::size_t i = 0; i < files.size(); ++i) {
      world["terrain"]["files"][i] = beside(files[i]);
    }
    if (const auto geoid = terrain->find("geoid")) world["terrain"]["geoid"] = beside(*geoid);
  }
  const auto vehicles = source.at("vehicles").items();
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    world["vehicles"][i]["vehicle"] = full_path(vehicles[i].at("vehicle"));
  }
}

/// The sensors' line: a board's, or the pseudo-terminal that ${CAS_AHRS_TTY} names.
void offer_ahrs_line(const RunRequest& request, const RunPaths& paths, YAML::Node plugins) {
  for (YAML::Node plugin : plugins) {
    if (plugin["plugin"].as<std::string>() != "external_ahrs") continue;
    if (const FcuDevice* board = request.fcu_device(0)) {
      plugin.remove("pty");
      plugin["device"] = board->sensors_path;
      plugin["unlocked_pty"] = true;
    } else {
      plugin.remove("device");
      plugin["pty"] = paths.ahrs_tty().string();
    }
  }
}

/// The line to the firmware: a board's, or one end of the cable.
void offer_serial_line(const RunRequest& request, const RunPaths& paths, YAML::Node link) {
  const FcuDevice* board = request.fcu_device(0);
  link["device"] = board != nullptr ? board->path : paths.casd_tty().string();
  if (board == nullptr) return;
  link["baud"] = board->baud;
  link["unlocked_pty"] = true;
}

/// The pseudo-terminal that ${CAS_GPS_TTY} names, for a plugin ubx that names no line of its own.
void offer_gps_line(const RunPaths& paths, YAML::Node plugins) {
  for (YAML::Node plugin : plugins) {
    if (plugin["plugin"].as<std::string>() != "ubx" || plugin["device"] || plugin["pty"]) continue;
    plugin["pty"] = paths.gps_tty().string();
  }
}

std::string world_text(const RunRequest& request, const RunPaths& paths) {
  const Scenario& scenario = request.scenario;
  const Firmware& firmware = *scenario.firmware;
  const base::ConfigNode& source = firmware.world;
  YAML::Node world = YAML::Load(source.dump());
  resolve_files(source, world);
  world["seed"] = request.seed;
  const bool is_paced = firmware.on_serial_line || request.clock == Clock::kWall;
  if (!is_paced) world.remove("speed");
  const auto vehicles = source.at("vehicles").items();
  std::string notes = base::origin_notes("", source);
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    YAML::Node vehicle = world["vehicles"][i];
    const auto& own = scenario.vehicles[i].sensors;
    if (const auto& set = own ? own : firmware.sensors) {
      vehicle["sensors"] = YAML::Load(set->dump());
      notes += sensors_origins(fmt::format("vehicles[{}].sensors", i), *set);
    }
    if (firmware.external_ahrs) offer_ahrs_line(request, paths, vehicle["plugins"]);
    add_scenario_plugins(request, i, vehicle["plugins"]);
    offer_gps_line(paths, vehicle["plugins"]);
    vehicle["plugins"].push_back(recorder_plugin(request, paths.vehicles.at(i)));
    notes += plugin_origins(scenario, i, vehicles.at(i).at("plugins").items().size());
  }
  return to_text(world) + notes;
}

bool is_for_a_station(const YAML::Node& link) {
  const YAML::Node accept = link["accept"];
  return accept && accept["traffic"] && accept["traffic"].as<std::string>() == "ground_station";
}

/// Gives a link that hils adds the routes of the topology's own link for a ground station; a
/// topology without routes connects all links. @param who  needs the link, for the error
void route_as_station(const RunRequest& request, YAML::Node topology, const std::string& link,
                      const char* who) {
  if (!topology["routes"]) return;
  const YAML::Node links = topology["links"];
  const auto own = std::find_if(links.begin(), links.end(), is_for_a_station);
  if (own == links.end()) {
    throw base::ConfigError(request.scenario.firmware->topology.file().string() + ": " + who +
                            ": it has routes, and no link of a ground station to copy");
  }
  const auto name = (*own)["name"].as<std::string>();
  std::vector<YAML::Node> copies;
  for (const YAML::Node& route : topology["routes"]) {
    YAML::Node copy = YAML::Clone(route);
    bool names_it = false;
    for (const char* end : {"from", "to"}) {
      if (route[end].as<std::string>() != name) continue;
      copy[end] = link;
      names_it = true;
    }
    if (names_it) copies.push_back(copy);
  }
  for (const YAML::Node& copy : copies) topology["routes"].push_back(copy);
}

std::string topology_text(const RunRequest& request, const RunPaths& paths) {
  const Firmware& firmware = *request.scenario.firmware;
  const base::ConfigNode& source = firmware.topology;
  YAML::Node topology = YAML::Load(source.dump());
  topology["command_port"]["port"] = 0;
  topology["command_port"]["unix"] = paths.command_port.string();
  topology["command_port"]["token_file"] = paths.command_token().string();
  if (firmware.outputs_disconnected) topology["commanding"]["allow_not_hil"] = true;
  topology["log"] = YAML::Node(YAML::NodeType::Map);
  topology["log"]["folder"] = paths.out.string();
  topology["log"]["tlog"] = "flight.tlog";
  topology["log"]["overwrite"] = true;
  for (const char* key : {"gains", "dialect"}) {
    if (const auto named = source.find(key)) topology[key] = full_path(*named);
  }
  for (YAML::Node link : topology["links"]) {
    if (firmware.on_serial_line && link["type"].as<std::string>() == "serial") {
      offer_serial_line(request, paths, link);
    }
  }
  if (request.station) {
    route_as_station(request, topology, kStationLink, "--gcs");
    topology["links"].push_back(ground_link(request, kStationLink, *request.station));
  }
  for (std::size_t i = 0; i < paths.companions.size(); ++i) {
    YAML::Node link;
    link["name"] = companion_link_name(i);
    link["type"] = "udp";
    link["local"] = "127.0.0.1:0";
    link["remote"] = fmt::format("127.0.0.1:{}", paths.companions[i]);
    route_as_station(request, topology, companion_link_name(i), "its steps need a link of hils");
    topology["links"].push_back(link);
  }
  return to_text(topology) + base::origin_notes("", source);
}

}  // namespace

std::string companion_link_name(std::size_t vehicle) {
  return std::string(CompanionStation::kLink) + (vehicle == 0 ? "" : std::to_string(vehicle + 1));
}

bool needs_companion(const Scenario& scenario) {
  if (scenario.firmware && scenario.firmware->tells_origin) return true;
  return std::ranges::any_of(
      scenario.steps, [](const FlightStep& step) { return CompanionFlight::gives(step.kind); });
}

void check_firmware_board(const RunRequest& request) {
  if (request.fcu_devices.empty()) return;
  refuse_emulator_faults(request);
  if (!request.scenario.firmware->external_ahrs) return;
  const FcuDevice& board = request.fcu_devices.begin()->second;
  if (!board.outputs_disconnected) {
    throw base::ConfigError(fmt::format(
        "--fcu: the outputs of the board at {} are live: its entry in boards.yaml needs "
        "outputs_disconnected: true, your word that no motor, ESC or servo is connected",
        board.path));
  }
  if (board.sensors_path.empty()) {
    throw base::ConfigError(fmt::format(
        "--fcu: the entry in boards.yaml of the board at {} needs sensors_device, the port that "
        "leads to its External AHRS",
        board.path));
  }
}

void write_firmware_configs(const RunRequest& request, const RunPaths& paths) {
  base::make_result_folder({paths.out, paths.run});
  base::write_result({paths.out, paths.simulator_config()}, world_text(request, paths));
  base::write_result({paths.out, paths.casd_config()}, topology_text(request, paths));
}

}  // namespace cas::hils
