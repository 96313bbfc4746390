// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/firmware.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>

#include "base/config/install_paths.hpp"
#include "base/config/removed_keys.hpp"
#include "base/error.hpp"
#include "base/suggestion.hpp"
#include "hils/flight/phase_check.hpp"
#include "hils/scenario/firmware_files.hpp"
#include "hils/scenario/handed_on_keys.hpp"
#include "hils/scenario/scenario.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::hils {

namespace {

bool names_instance(const std::string& text) {
  return text.find("${CAS_INSTANCE}") != std::string::npos;
}

/// Several programs need ports and folders of their own. @throws base::ConfigError
void check_instances(const base::ConfigNode& node, const Firmware& firmware,
                     std::size_t instances) {
  if (instances == 1) return;
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

/// An autopilot by External AHRS drives its real outputs, whatever flies. @throws base::ConfigError
void check_outputs(const base::ConfigNode& node, const Firmware& firmware) {
  if (!firmware.external_ahrs) {
    if (const auto word = node.find("outputs_disconnected")) {
      word->fail("is for a world with plugin external_ahrs");
    }
    return;
  }
  if (!firmware.on_serial_line) {
    node.fail("needs on_serial_line: true: an autopilot by External AHRS flies in real time");
  }
  if (!firmware.outputs_disconnected) {
    node.fail(
        "needs outputs_disconnected: true, your word that no motor, ESC or servo is connected: "
        "ArduPilot has no HIL mode, and its outputs are live");
  }
}

/// The vehicles of a world's file. @throws base::ConfigError
std::vector<ScenarioVehicle> flown_vehicles(const base::ConfigNode& world) {
  const auto listed = world.at("vehicles").items();
  if (listed.empty()) world.at("vehicles").fail("names no vehicle");
  if (listed.size() > kMostInstances) world.at("vehicles").fail("a run has at most 16 vehicles");
  std::vector<ScenarioVehicle> vehicles(listed.size());
  for (std::size_t i = 0; i < listed.size(); ++i) {
    vehicles[i].name = listed[i].get<std::string>("name", std::string(kVehicleName));
    vehicles[i].vehicle = base::find_config(listed[i].at("vehicle"));
    if (const auto pose = listed[i].find("pose")) {
      vehicles[i].pose.x_m = pose->get("x_m", 0.0);
      vehicles[i].pose.y_m = pose->get("y_m", 0.0);
      vehicles[i].pose.yaw_deg = pose->get("yaw_deg", 0.0);
    } else {
      vehicles[i].pose.yaw_deg = 0;
    }
  }
  return vehicles;
}

/// The system ids of PX4's instances; the first HEARTBEAT of a single one may tell another.
void name_systems(Scenario& scenario) {
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    scenario.vehicles[i].system_id = system_of_instance(i);
  }
}

/// The world's own, for the seed and place of a run.
void read_world(const base::ConfigNode& world, Scenario& scenario) {
  scenario.seed = world.get("seed", scenario.seed);
  scenario.decimal_year = world.get("decimal_year", scenario.decimal_year);
  if (const auto home = world.find("home")) {
    scenario.home = base::Geodetic{.lat_deg = home->require<double>("lat_deg"),
                                   .lon_deg = home->require<double>("lon_deg"),
                                   .alt_m = home->get("alt_m", 0.0)};
  }
}

constexpr std::string_view kExternalAhrs = "external_ahrs";

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
  firmware.outputs_disconnected = node.get("outputs_disconnected", false);
  firmware.tells_origin = node.get("tells_origin", false);
  base::refuse_removed(
      node,
      {{"instances", "each vehicle of the world has an instance; or name them in `vehicles`"}});
  return firmware;
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
void parse_fence(const base::ConfigNode& root, Scenario& scenario) {
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

/// The loops that casd will know with this topology.
casd::GainMap gains_of(const base::ConfigNode& topology) {
  const auto gains = topology.find("gains");
  return gains ? casd::GainMap::load(base::find_config(*gains)) : casd::GainMap::shipped();
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
void check_cuts(const base::ConfigNode& faults, const base::ConfigNode& topology) {
  std::vector<std::string> names;
  for (const base::ConfigNode& link : topology.at("links").items()) {
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
void parse_faults(const base::ConfigNode& node, Scenario& scenario) {
  const Firmware& firmware = *scenario.firmware;
  scenario.faults = parse_scenario_faults(node, base::ConfigNode::empty("line"), scenario.names());
  refuse_faults(node, std::array<std::string_view, 2>{"flood_hz", "starve"},
                "a flight of stock firmware does not have this fault");
  check_silences(node, scenario);
  if (!firmware.on_serial_line) {
    refuse_faults(node, std::array<std::string_view, 2>{"line", "unplug"},
                  "this firmware has no serial line of hils (firmware: on_serial_line)");
  }
  check_cuts(node, firmware.topology);
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    check_fault_plugins(plugins_of(scenario, i), scenario.faults.of_vehicle(i));
  }
  check_fault_phases(node, scenario.steps);
}

/// Takes simulation and topology from files. @throws base::ConfigError
void read_files(const base::ConfigNode& root, Scenario& scenario, Firmware& firmware) {
  firmware.world = base::ConfigNode::load(base::find_config(root.at("world")));
  firmware.topology = base::ConfigNode::load(base::find_config(root.at("topology")));
  if (const auto autopilot = root.at("firmware").find("autopilot")) {
    autopilot->fail("the world's interface plugin says it; it goes with `vehicle` or `vehicles`");
  }
  scenario.vehicles = flown_vehicles(firmware.world);
  name_systems(scenario);
  const base::ConfigNode first = firmware.world.at("vehicles").items().front();
  firmware.autopilot = served_autopilot(first);
  firmware.external_ahrs =
      plugin_names(first.at("plugins").items()).contains(std::string(kExternalAhrs));
  read_world(firmware.world, scenario);
}

/// Makes simulation and topology for the vehicles of the scenario. @throws base::ConfigError
void make_files(const base::ConfigNode& root, Scenario& scenario, Firmware& firmware) {
  const base::ConfigNode autopilot = root.at("firmware").at("autopilot");
  firmware.autopilot = autopilot.as<std::string>();
  if (firmware.autopilot != "PX4" && firmware.autopilot != "ArduPilot") {
    autopilot.fail("is PX4 or ArduPilot");
  }
  if (firmware.on_serial_line && firmware.autopilot != "PX4") {
    autopilot.fail("on a serial line is PX4");
  }
  if (firmware.autopilot == "ArduPilot" && root.has("step_us")) {
    root.at("step_us").fail("ArduPilot asks for its own steps, 1200 a second");
  }
  const auto vehicles = root.find("vehicles");
  for (const auto& vehicle : vehicles ? vehicles->items() : std::vector<base::ConfigNode>{}) {
    if (const auto own = vehicle.find("controller")) {
      own->fail("stock firmware has parameters of its own");
    }
  }
  name_systems(scenario);
  firmware.world = firmware_world(scenario, firmware);
  firmware.topology = firmware_topology(scenario, firmware);
}

/// Limits that mean something to stock firmware beside those of every controller.
/// @throws base::ConfigError
void parse_limits(const base::ConfigNode& limits, Scenario& scenario) {
  refuse_drift(limits, scenario.steps);
  scenario.limits.rates_hz = parse_rates(limits);
  for (const char* const key : {"lost", "delivered_pct", "rate_error_pct"}) {
    if (!scenario.firmware->on_serial_line && limits.has(key)) {
      limits.at(key).fail(
          "firmware in software waits for each packet: its HIL stream has no limit");
    }
  }
}

}  // namespace

std::string_view autopilot_of_plugin(std::string_view plugin) {
  if (plugin == "mavlink_interface") return "PX4";
  return plugin == "ardupilot_json" || plugin == kExternalAhrs ? "ArduPilot" : "";
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

void read_firmware(const base::ConfigNode& root, Scenario& scenario) {
  Firmware firmware = parse_firmware(root.at("firmware"));
  firmware.not_hil = root.get("not_hil", false);
  firmware.sensors = root.find("sensors");
  if (firmware.sensors) firmware.sensors->mark_used();
  scenario.vehicles.empty() ? read_files(root, scenario, firmware)
                            : make_files(root, scenario, firmware);
  check_instances(root.at("firmware"), firmware, scenario.vehicles.size());
  check_outputs(root.at("firmware"), firmware);
  if (firmware.tells_origin && (firmware.autopilot != "PX4" || !scenario.home)) {
    root.at("firmware").at("tells_origin").fail("is for PX4, in a world with a home");
  }
  firmware.not_hil |= firmware.outputs_disconnected;
  scenario.architecture = firmware.on_serial_line ? Architecture::kTcas : Architecture::kSitl;
  scenario.steps = parse_flight(root.at("steps"), gains_of(firmware.topology), scenario.names());
  scenario.firmware = std::move(firmware);
  parse_fence(root, scenario);
  if (root.has("plugins")) {
    scenario.plugins = root.at("plugins").items();
    root.at("plugins").mark_used();
  }
  check_firmware_sensors(scenario);
  if (root.has("faults")) parse_faults(root.at("faults"), scenario);
  if (root.has("limits")) parse_limits(root.at("limits"), scenario);
}

}  // namespace cas::hils
