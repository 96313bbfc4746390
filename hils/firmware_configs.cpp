// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware_configs.hpp"

#include <yaml-cpp/yaml.h>

#include <string>

#include "hils/report.hpp"

namespace cas::hils {
namespace {

constexpr double kTruthHz = 100;

std::string to_text(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << node;
  return std::string(emitter.c_str()) + "\n";
}

/// A path of the shipped file, which is relative to that file's folder.
std::string full_path(const YAML::Node& node, const std::filesystem::path& file) {
  return std::filesystem::weakly_canonical(file.parent_path() / node.as<std::string>()).string();
}

std::string world_text(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  YAML::Node world = YAML::LoadFile(scenario.world.string());
  for (YAML::Node vehicle : world["vehicles"]) {
    vehicle["vehicle"] = full_path(vehicle["vehicle"], scenario.world);
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
  if (topology["gains"]) topology["gains"] = full_path(topology["gains"], scenario.topology);
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
  write_text(places.simulator_config(), world_text(scenario, places));
  write_text(places.casd_config(), topology_text(scenario, places));
}

}  // namespace cas::hils
