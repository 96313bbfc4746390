// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_configs.hpp"

#include <yaml-cpp/yaml.h>

#include <string>

#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"
#include "base/os/write_file.hpp"
#include "hils/report/report.hpp"

namespace cas::hils {
namespace {

constexpr double kTruthHz = 100;

std::string to_text(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << node;
  return std::string(emitter.c_str()) + "\n";
}

/// The whole path of the file that a key names: what is written from it lies elsewhere.
std::string full_path(const base::ConfigNode& key) {
  return std::filesystem::weakly_canonical(base::find_config(key)).string();
}

std::string world_text(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  YAML::Node world = YAML::LoadFile(scenario.world.string());
  const auto source = base::ConfigNode::load(scenario.world);
  const auto scene = source.at("world");
  if (scene.is_scalar()) world["world"] = full_path(scene);
  const auto vehicles = source.at("vehicles").items();
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    world["vehicles"][i]["vehicle"] = full_path(vehicles[i].at("vehicle"));
  }
  YAML::Node recorder;
  recorder["plugin"] = "recorder";
  recorder["file"] = (places.out / "truth.csv").string();
  recorder["rate_hz"] = kTruthHz;
  world["vehicles"][0]["plugins"].push_back(recorder);
  return to_text(world);
}

std::string topology_text(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  YAML::Node topology = YAML::LoadFile(scenario.topology.string());
  topology["command_port"]["port"] = 0;
  topology["command_port"]["unix"] = places.command_port().string();
  topology["log"]["tlog"] = (places.out / "flight.tlog").string();
  const auto source = base::ConfigNode::load(scenario.topology);
  for (const char* key : {"gains", "dialect"}) {
    if (const auto named = source.find(key)) topology[key] = full_path(*named);
  }
  for (YAML::Node link : topology["links"]) {
    if (scenario.firmware.on_serial_line && link["type"].as<std::string>() == "serial") {
      link["device"] = places.casd_tty().string();
    }
  }
  return to_text(topology);
}

}  // namespace

void write_firmware_configs(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  std::filesystem::create_directories(places.run);
  base::write_file(places.simulator_config(), world_text(scenario, places),
                   base::Durability::kCache);
  base::write_file(places.casd_config(), topology_text(scenario, places), base::Durability::kCache);
}

}  // namespace cas::hils
