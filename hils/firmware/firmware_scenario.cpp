// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_scenario.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string>

#include "base/config/config.hpp"
#include "base/config/config_origin.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "hils/flight/phase_check.hpp"
#include "hils/scenario/scenario.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::hils {

namespace {

constexpr int kSchema = 1;

Firmware parse_firmware(const base::ConfigNode& node) {
  Firmware firmware;
  firmware.command = node.require<std::vector<std::string>>("command");
  if (firmware.command.empty()) node.at("command").fail("names no program");
  firmware.start = node.get<std::string>("start", "");
  if (!firmware.start.empty()) {
    firmware.command.insert(firmware.command.end(), {"-s", firmware.start});
  }
  firmware.least_version = node.get<std::string>("least_version", "");
  if (firmware.least_version.find_first_not_of("0123456789.") != std::string::npos) {
    node.at("least_version").fail("is numbers with dots between them, such as '1.12'");
  }
  firmware.hint = node.get<std::string>("hint", "");
  firmware.cwd = node.get<std::string>("cwd", "");
  if (const auto variables = node.find("environment")) {
    for (const auto& [name, value] : variables->entries()) {
      firmware.environment[name] = value.as<std::string>();
    }
  }
  firmware.on_serial_line = node.get("on_serial_line", false);
  return firmware;
}

/// Stock firmware has no parameters CAS_TRJ_*.
void refuse_trajectories(const base::ConfigNode& steps, const std::vector<FlightStep>& flight) {
  const bool any = std::ranges::any_of(
      flight, [](const FlightStep& step) { return step.kind == StepKind::kTrajectory; });
  if (!any) return;
  for (const base::ConfigNode& node : steps.items()) {
    if (node.is_map() && node.has("trajectory")) {
      node.at("trajectory")
          .fail(
              "only the controller of CAS flies a trajectory by itself: stock firmware takes goto");
    }
  }
}

std::optional<double> limit(const base::ConfigNode& limits, std::string_view key) {
  if (!limits.has(key)) return std::nullopt;
  return limits.require_in(key, 0, 1000);
}

/// The loops that casd will know with this topology.
casd::GainMap gains_of(const std::filesystem::path& topology) {
  const auto gains = base::ConfigNode::load(topology).find("gains");
  return gains ? casd::GainMap::load(base::find_config(*gains)) : casd::GainMap::shipped();
}

constexpr double kTruthHz = 100;

std::string to_text(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << node;
  return std::string(emitter.c_str()) + "\n";
}

/// Full path of the file that a key names, because the generated file lies elsewhere.
std::string full_path(const base::ConfigNode& key) {
  return std::filesystem::weakly_canonical(base::find_config(key)).string();
}

/// Rates by the name of a message.
std::map<std::string, double> parse_rates(const base::ConfigNode& limits) {
  constexpr double kMost_hz = 10'000;
  std::map<std::string, double> rates;
  const auto node = limits.find("rates_hz");
  if (!node) return rates;
  for (const auto& [name, value] : node->entries()) {
    if (mav::public_table().find(mav::TextView(name)) == nullptr) {
      value.fail("'" + name + "' is no message");
    }
    rates[name] = node->require_in(name, 0, kMost_hz);
  }
  return rates;
}

/// The faults of the vehicle. @throws base::ConfigError for one of the bench
std::vector<VehicleFault> parse_faults(const base::ConfigNode& node, const std::string& vehicle) {
  const ScenarioFaults faults =
      parse_scenario_faults(node, base::ConfigNode::empty("line"), {vehicle});
  if (faults.bench.empty()) return faults.vehicle;
  node.fail("'" + faults.bench.front().name +
            "' is a fault of the bench, which a flight of stock firmware does not have: it takes "
            "those of the vehicle (plugin fault)");
}

/// What a scenario adds to the plugins of the world's vehicle.
void add_plugins(const FirmwareScenario& scenario, YAML::Node plugins) {
  for (const base::ConfigNode& plugin : scenario.plugins) {
    YAML::Node node = YAML::Load(plugin.dump());
    if (const auto grid = plugin.find("grid")) node["grid"] = full_path(*grid);
    plugins.push_back(node);
  }
  if (scenario.faults.empty()) return;
  YAML::Node fault;
  fault["plugin"] = "fault";
  for (const VehicleFault& each : scenario.faults) {
    YAML::Node script = YAML::Load(each.script.dump());
    script.remove("vehicle");
    fault["faults"].push_back(script);
  }
  plugins.push_back(fault);
}

std::string world_text(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  YAML::Node world = YAML::LoadFile(scenario.world.string());
  const auto source = base::ConfigNode::load(scenario.world);
  const auto scene = source.at("world");
  if (scene.is_scalar()) world["world"] = full_path(scene);
  const auto folders = source.get("model_path", std::vector<std::string>{});
  for (std::size_t i = 0; i < folders.size(); ++i) {
    world["model_path"][i] = std::filesystem::weakly_canonical(source.resolve(folders[i])).string();
  }
  const auto vehicles = source.at("vehicles").items();
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    world["vehicles"][i]["vehicle"] = full_path(vehicles[i].at("vehicle"));
  }
  if (scenario.sensors) {
    world["vehicles"][0]["sensors"] = YAML::Load(scenario.sensors->dump());
  }
  add_plugins(scenario, world["vehicles"][0]["plugins"]);
  YAML::Node recorder;
  recorder["plugin"] = "recorder";
  recorder["file"] = (places.out / "truth.csv").string();
  recorder["rate_hz"] = kTruthHz;
  world["vehicles"][0]["plugins"].push_back(recorder);
  std::string notes = base::origin_notes("", source);
  std::size_t number = vehicles.at(0).at("plugins").items().size();
  for (const base::ConfigNode& plugin : scenario.plugins) {
    notes += base::origin_notes("vehicles[0].plugins[" + std::to_string(number++) + "]", plugin);
  }
  for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
    notes += base::origin_notes(
        "vehicles[0].plugins[" + std::to_string(number) + "].faults[" + std::to_string(i) + "]",
        scenario.faults[i].script);
  }
  return to_text(world) + notes;
}

std::string topology_text(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  YAML::Node topology = YAML::LoadFile(scenario.topology.string());
  topology["command_port"]["port"] = 0;
  topology["command_port"]["unix"] = places.command_port.string();
  topology["command_port"]["token_file"] = places.command_token().string();
  topology["log"] = YAML::Node(YAML::NodeType::Map);
  topology["log"]["folder"] = places.out.string();
  topology["log"]["tlog"] = "flight.tlog";
  topology["log"]["overwrite"] = true;
  const auto source = base::ConfigNode::load(scenario.topology);
  for (const char* key : {"gains", "dialect"}) {
    if (const auto named = source.find(key)) topology[key] = full_path(*named);
  }
  for (YAML::Node link : topology["links"]) {
    if (scenario.firmware.on_serial_line && link["type"].as<std::string>() == "serial") {
      link["device"] = places.casd_tty().string();
    }
  }
  return to_text(topology) + base::origin_notes("", base::ConfigNode::load(scenario.topology));
}

}  // namespace

bool is_at_least(const std::string& version, const std::string& least) {
  const auto numbers = [](const std::string& text) {
    std::vector<int> all;
    for (const char* at = text.data(); at < text.data() + text.size();) {
      int number = 0;
      const auto [end, error] = std::from_chars(at, text.data() + text.size(), number);
      all.push_back(number);
      at = end + 1;  // behind the dot
    }
    return all;
  };
  return numbers(version) >= numbers(least);
}

std::string with_variables(const std::string& text,
                           const std::map<std::string, std::string>& more) {
  std::string result;
  std::size_t at = 0;
  for (std::size_t begin = text.find("${"); begin != std::string::npos;
       begin = text.find("${", at)) {
    const std::size_t end = text.find('}', begin);
    if (end == std::string::npos) break;
    const std::string inside = text.substr(begin + 2, end - begin - 2);
    const std::size_t colon = inside.find(":-");
    const std::string name = inside.substr(0, colon);
    const std::string fallback = colon == std::string::npos ? "" : inside.substr(colon + 2);
    const auto own = more.find(name);
    const char* value = own == more.end() ? std::getenv(name.c_str()) : own->second.c_str();
    if (value == nullptr && colon != std::string::npos) value = fallback.c_str();
    if (value == nullptr) {
      throw base::ConfigError("set the environment variable " + name +
                              ": it says where the firmware is ('" + text + "')");
    }
    result += text.substr(at, begin - at) + value;
    at = end + 1;
  }
  return result + text.substr(at);
}

bool FirmwareScenario::is(const std::filesystem::path& file) {
  return base::ConfigNode::load(file).has("firmware");
}

FirmwareScenario FirmwareScenario::load(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  if (root.require<int>("schema") != kSchema) root.at("schema").fail("this program reads schema 1");
  FirmwareScenario scenario;
  scenario.name = root.get<std::string>("name", file.stem().string());
  scenario.description = root.get<std::string>("description", "");
  scenario.file = file;
  scenario.world = base::find_config(root.at("world"));
  const auto vehicle = base::ConfigNode::load(scenario.world).at("vehicles").items().at(0);
  scenario.vehicle = vehicle.get<std::string>("name", scenario.vehicle);
  scenario.topology = base::find_config(root.at("topology"));
  scenario.firmware = parse_firmware(root.at("firmware"));
  scenario.not_hil = root.get("not_hil", false);
  scenario.steps = parse_flight(root.at("steps"), gains_of(scenario.topology));
  refuse_trajectories(root.at("steps"), scenario.steps);
  scenario.sensors = root.find("sensors");
  if (scenario.sensors) scenario.sensors->mark_used();
  if (root.has("plugins")) {
    scenario.plugins = root.at("plugins").items();
    root.at("plugins").mark_used();
  }
  if (root.has("faults")) {
    scenario.faults = parse_faults(root.at("faults"), scenario.vehicle);
    auto plugins = vehicle.at("plugins").items();
    plugins.insert(plugins.end(), scenario.plugins.begin(), scenario.plugins.end());
    check_gusts(plugins, {.bench = {}, .vehicle = scenario.faults});
    check_fault_phases(root.at("faults"), scenario.steps);
  }
  if (const auto limits = root.find("limits")) {
    scenario.height_error_m = limit(*limits, "height_error_m");
    scenario.drift_m = limit(*limits, "drift_m");
    scenario.rms = parse_axes(*limits, "rms");
    scenario.rms_estimate = parse_axes(*limits, "rms_estimate");
    if (limits->has("hop_p99_us")) scenario.hop_p99_us = limits->require_in("hop_p99_us", 0, 1e9);
    scenario.rates_hz = parse_rates(*limits);
  }
  root.reject_unused();
  return scenario;
}

void write_firmware_configs(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  std::filesystem::create_directories(places.run);
  base::write_file(places.simulator_config(), world_text(scenario, places),
                   base::Durability::kCache);
  base::write_file(places.casd_config(), topology_text(scenario, places), base::Durability::kCache);
}

}  // namespace cas::hils
