// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_scenario.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <string>
#include <string_view>

#include "base/angles.hpp"
#include "base/config/config.hpp"
#include "base/config/config_origin.hpp"
#include "base/config/config_whole.hpp"
#include "base/config/install_paths.hpp"
#include "base/earth/frames.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/suggestion.hpp"
#include "hils/firmware/companion_flight.hpp"
#include "hils/firmware/first_sign.hpp"
#include "hils/flight/phase_check.hpp"
#include "hils/programs/composition.hpp"
#include "hils/scenario/scenario.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::hils {

namespace {

constexpr int kSchema = 1;

bool names_instance(const std::string& text) {
  return text.find("${CAS_INSTANCE}") != std::string::npos;
}

/// Several programs need ports and folders of their own. @throws base::ConfigError
void check_instances(const base::ConfigNode& node, const Firmware& firmware) {
  if (firmware.instances == 1) return;
  if (firmware.on_serial_line) {
    node.at("on_serial_line").fail("several instances fly in software only, without a serial line");
  }
  const bool differ = std::ranges::any_of(firmware.command, names_instance) ||
                      std::ranges::any_of(firmware.environment, names_instance,
                                          [](const auto& entry) { return entry.second; });
  if (!differ) {
    node.at("command").fail(
        "several instances need ${CAS_INSTANCE} in it, the number from 0 of each (PX4: -i, "
        "ArduPilot: -I)");
  }
  if (!firmware.cwd.empty() && !names_instance(firmware.cwd)) {
    node.at("cwd").fail("several instances need ${CAS_INSTANCE} in it, a folder for each");
  }
}

/// The world's first vehicles, which are flown. @throws base::ConfigError
VehicleNames flown_vehicles(const base::ConfigNode& firmware, const base::ConfigNode& world,
                            int instances) {
  const auto vehicles = world.at("vehicles").items();
  const auto count = static_cast<std::size_t>(instances);
  if (vehicles.size() < count) {
    firmware.at("instances")
        .fail("the world has only " + std::to_string(vehicles.size()) + " of them");
  }
  VehicleNames names;
  for (std::size_t i = 0; i < count; ++i) {
    names.push_back(vehicles[i].get<std::string>("name", std::string(kVehicleName)));
  }
  return names;
}

std::string served_autopilot(const base::ConfigNode& vehicle) {
  for (const base::ConfigNode& plugin : vehicle.at("plugins").items()) {
    const auto served = autopilot_of_plugin(plugin.get<std::string>("plugin", ""));
    if (!served.empty()) return std::string(served);
  }
  return {};
}

Firmware parse_firmware(const base::ConfigNode& node) {
  Firmware firmware;
  firmware.node = node;
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
  firmware.instances = base::get_whole_in<int>(node, "instances", 1, 1, kMostInstances);
  check_instances(node, firmware);
  return firmware;
}

/// Heading of each vehicle in the world file, where yaw counts from east, counter-clockwise.
std::vector<double> start_headings(const base::ConfigNode& world, std::size_t count) {
  constexpr double kNorth_deg = 90;
  std::vector<double> headings;
  const auto vehicles = world.at("vehicles").items();
  for (std::size_t i = 0; i < count; ++i) {
    const auto pose = vehicles[i].find("pose");
    const double yaw_deg = pose ? pose->get("yaw_deg", 0.0) : 0.0;
    headings.push_back(base::wrap_angle((kNorth_deg - yaw_deg) * base::kRadPerDeg));
  }
  return headings;
}

/// A vehicle on a trajectory leaves its start, so a limit on drift is refused.
/// @throws base::ConfigError
void refuse_drift(const base::ConfigNode& limits, const std::vector<FlightStep>& flight) {
  const bool moves = std::ranges::any_of(flight, [](const FlightStep& step) {
    return step.measure && step.kind == StepKind::kTrajectory;
  });
  for (const char* const key : {"drift_m", "height_error_m"}) {
    if (moves && limits.has(key)) {
      limits.at(key).fail("the measured step is a trajectory: it is held to rms");
    }
  }
}

bool is_breach(const FlightStep& step) { return step.kind == StepKind::kBreach; }

/// Whether the fence and its margin leave a place to the vehicle.
bool allows(const Geofence& fence, const Eigen::Vector3d& place_m) {
  const bool low = !fence.altitude_m || place_m.z() <= *fence.altitude_m + fence.margin_m;
  return place_m.head<2>().norm() <= fence.radius_m + fence.margin_m && low;
}

/// A fence that nothing flies to would never act. @throws base::ConfigError
void parse_fence(const base::ConfigNode& root, FirmwareScenario& scenario) {
  const bool flies_there = std::ranges::any_of(scenario.steps, is_breach);
  if (!root.has("geofence")) {
    if (flies_there) root.at("steps").fail("a breach step needs the section geofence");
    return;
  }
  const base::ConfigNode node = root.at("geofence");
  scenario.fence = parse_geofence(node);
  if (!flies_there) node.fail("no breach step flies to this fence: it would never act");
  for (FlightStep& step : scenario.steps) {
    if (!is_breach(step)) continue;
    step.fence = scenario.fence->action;
    if (allows(*scenario.fence, step.place_m)) {
      node.fail("the place of a breach step is not beyond the fence and its margin");
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

/// A fault that closes a link names one of the topology. @throws base::ConfigError
void check_cuts(const base::ConfigNode& faults, const std::filesystem::path& topology) {
  std::vector<std::string> names;
  for (const base::ConfigNode& link : base::ConfigNode::load(topology).at("links").items()) {
    names.push_back(link.get<std::string>("name", ""));
  }
  for (const base::ConfigNode& fault : faults.items()) {
    const auto cut = fault.find("cut");
    if (!cut || std::ranges::find(names, cut->as<std::string>()) != names.end()) continue;
    cut->fail("the topology has no link of this name" +
              base::did_you_mean(cut->as<std::string>(), names));
  }
}

/// The faults of the flight. @throws base::ConfigError for those that cannot be played
ScenarioFaults parse_faults(const base::ConfigNode& node, const FirmwareScenario& scenario) {
  ScenarioFaults faults =
      parse_scenario_faults(node, base::ConfigNode::empty("line"), scenario.vehicles);
  refuse_faults(node, std::array<std::string_view, 3>{"flood_hz", "silence", "starve"},
                "a flight of stock firmware does not have this fault");
  if (!scenario.firmware.on_serial_line) {
    refuse_faults(node, std::array<std::string_view, 2>{"line", "unplug"},
                  "this firmware has no serial line of hils (firmware: on_serial_line)");
  }
  check_cuts(node, scenario.topology);
  return faults;
}

/// Those that plugin fault of one vehicle plays.
std::vector<VehicleFault> faults_of(const FirmwareScenario& scenario, std::size_t vehicle) {
  std::vector<VehicleFault> faults;
  std::ranges::copy_if(
      scenario.faults.vehicle, std::back_inserter(faults),
      [vehicle](const VehicleFault& fault) { return fault.vehicle.value_or(vehicle) == vehicle; });
  return faults;
}

/// Adds the scenario's plugins to those of a vehicle in the world.
void add_plugins(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                 std::size_t vehicle, YAML::Node plugins) {
  for (const base::ConfigNode& plugin : scenario.plugins) {
    YAML::Node node = YAML::Load(plugin.dump());
    if (const auto grid = plugin.find("grid")) node["grid"] = full_path(*grid);
    plugins.push_back(node);
  }
  YAML::Node fault;
  fault["plugin"] = "fault";
  for (const VehicleFault& each : faults_of(scenario, vehicle)) {
    YAML::Node script = YAML::Load(each.script.dump());
    script.remove("vehicle");
    fault["faults"].push_back(script);
  }
  if (fault["faults"]) plugins.push_back(fault);
  YAML::Node recorder;
  recorder["plugin"] = "recorder";
  recorder["file"] =
      places.truth_csv(scenario.suffix_of(vehicle)).lexically_relative(places.out).string();
  recorder["rate_hz"] = kTruthHz;
  plugins.push_back(recorder);
}

/// Notes on the origin of the plugins that add_plugins() has added.
std::string plugin_notes(const FirmwareScenario& scenario, std::size_t vehicle,
                         std::size_t number_of_own) {
  const auto path = [vehicle](std::size_t plugin) {
    return "vehicles[" + std::to_string(vehicle) + "].plugins[" + std::to_string(plugin) + "]";
  };
  std::string notes;
  std::size_t number = number_of_own;
  for (const base::ConfigNode& plugin : scenario.plugins) {
    notes += base::origin_notes(path(number++), plugin);
  }
  std::size_t fault = 0;
  for (const VehicleFault& each : faults_of(scenario, vehicle)) {
    notes +=
        base::origin_notes(path(number) + ".faults[" + std::to_string(fault++) + "]", each.script);
  }
  return notes;
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
  std::string notes = base::origin_notes("", source);
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    YAML::Node vehicle = world["vehicles"][i];
    if (scenario.sensors) vehicle["sensors"] = YAML::Load(scenario.sensors->dump());
    add_plugins(scenario, places, i, vehicle["plugins"]);
    notes += plugin_notes(scenario, i, vehicles.at(i).at("plugins").items().size());
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
  for (std::size_t i = 0; i < places.companions.size(); ++i) {
    YAML::Node link;
    link["name"] = companion_link_name(i);
    link["type"] = "udp";
    link["local"] = "127.0.0.1:0";
    link["remote"] = "127.0.0.1:" + std::to_string(places.companions[i]);
    topology["links"].push_back(link);
  }
  return to_text(topology) + base::origin_notes("", base::ConfigNode::load(scenario.topology));
}

}  // namespace

std::string companion_link_name(std::size_t vehicle) {
  return std::string(CompanionStation::kLink) + (vehicle == 0 ? "" : std::to_string(vehicle + 1));
}

bool FirmwareScenario::needs_companion() const {
  return std::ranges::any_of(
      steps, [](const FlightStep& step) { return CompanionFlight::gives(step.kind); });
}

bool is_of_a_tree_without_tags(const std::string& version) {
  return version == "1.8.0" || version == "0.0.0";
}

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
  scenario.topology = base::find_config(root.at("topology"));
  scenario.firmware = parse_firmware(root.at("firmware"));
  const base::ConfigNode world = base::ConfigNode::load(scenario.world);
  scenario.vehicles = flown_vehicles(root.at("firmware"), world, scenario.firmware.instances);
  scenario.autopilot = served_autopilot(world.at("vehicles").items().front());
  scenario.not_hil = root.get("not_hil", false);
  scenario.steps = parse_flight(root.at("steps"), gains_of(scenario.topology), scenario.vehicles);
  parse_fence(root, scenario);
  scenario.start_yaw_rad = start_headings(world, scenario.vehicles.size());
  scenario.sensors = root.find("sensors");
  if (scenario.sensors) scenario.sensors->mark_used();
  if (root.has("plugins")) {
    scenario.plugins = root.at("plugins").items();
    root.at("plugins").mark_used();
  }
  if (root.has("faults")) {
    scenario.faults = parse_faults(root.at("faults"), scenario);
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      auto plugins = world.at("vehicles").items().at(i).at("plugins").items();
      plugins.insert(plugins.end(), scenario.plugins.begin(), scenario.plugins.end());
      check_fault_plugins(plugin_names(plugins), faults_of(scenario, i));
    }
    check_fault_phases(root.at("faults"), scenario.steps);
  }
  if (const auto limits = root.find("limits")) {
    scenario.height_error_m = limit(*limits, "height_error_m");
    scenario.drift_m = limit(*limits, "drift_m");
    refuse_drift(*limits, scenario.steps);
    parse_motion_limits(*limits, scenario.limits);
    if (limits->has("hop_p99_us")) scenario.hop_p99_us = limits->require_in("hop_p99_us", 0, 1e9);
    scenario.rates_hz = parse_rates(*limits);
  }
  root.reject_unused();
  return scenario;
}

void write_firmware_configs(const FirmwareScenario& scenario, const FirmwarePlaces& places) {
  base::make_result_folder({places.out, places.run});
  base::write_result({places.out, places.simulator_config()}, world_text(scenario, places));
  base::write_result({places.out, places.casd_config()}, topology_text(scenario, places));
}

}  // namespace cas::hils
