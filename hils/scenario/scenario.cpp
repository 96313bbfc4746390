// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/scenario.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/config/config_whole.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"
#include "base/suggestion.hpp"
#include "hils/flight/phase_check.hpp"

namespace cas::hils {

namespace {

std::optional<double> optional_limit(const base::ConfigNode& node, std::string_view key,
                                     double most) {
  if (!node.has(key)) return std::nullopt;
  return node.require_in(key, 0, most);
}

bool has_response(const std::vector<FlightStep>& steps, std::string_view name) {
  return std::ranges::any_of(steps, [name](const FlightStep& step) {
    return step.trajectory.shape == fcu::PatternShape::kSteps && phase_of(step) == name;
  });
}

/// Each key is the name of a `trajectory: {shape: step}` of the flight.
std::map<std::string, ResponseLimits> parse_responses(const base::ConfigNode& limits,
                                                      const std::vector<FlightStep>& steps) {
  std::map<std::string, ResponseLimits> responses;
  const std::optional<base::ConfigNode> node = limits.find("responses");
  if (!node) return responses;
  for (const auto& [name, body] : node->entries()) {
    if (!has_response(steps, name))
      body.fail("the flight has no 'trajectory: {shape: step}' of that name");
    responses[name] = {.rise_s = optional_limit(body, "rise_s", 1e6),
                       .overshoot_pct = optional_limit(body, "overshoot_pct", 1e6),
                       .settling_s = optional_limit(body, "settling_s", 1e6)};
  }
  return responses;
}

/// Reads the block `limits`; its `responses` name steps of the flight.
Limits parse_limits(const base::ConfigNode& node, const std::vector<FlightStep>& steps) {
  Limits limits;
  limits.delivered_pct = optional_limit(node, "delivered_pct", 100);
  limits.responses = parse_responses(node, steps);
  if (node.has("lost")) limits.lost = node.require<std::uint64_t>("lost");
  if (node.has("rate_error_pct")) limits.rate_error_pct = node.require_in("rate_error_pct", 0, 100);
  if (node.has("latency_p99_us")) limits.latency_p99_us = node.require_in("latency_p99_us", 0, 1e9);
  limits.rms = parse_axes(node, "rms");
  limits.rms_estimate = parse_axes(node, "rms_estimate");
  return limits;
}

/// Reads the list `allow`: incidents that fail no run.
std::set<IncidentKind> parse_allow(const base::ConfigNode& root) {
  std::set<IncidentKind> allowed;
  const std::optional<base::ConfigNode> list = root.find("allow");
  if (!list) return allowed;
  for (const base::ConfigNode& node : list->items()) {
    const auto word = node.as<std::string>();
    const auto kind =
        std::ranges::find(kIncidentKinds, word, [](IncidentKind each) { return to_string(each); });
    if (kind == kIncidentKinds.end()) {
      node.fail("'" + word +
                "' is no incident; there are ground, crash, attitude, flyaway and strike");
    }
    allowed.insert(*kind);
  }
  return allowed;
}

/// Limits of one vehicle of several: without responses to steps that others fly.
Limits limits_for(std::size_t vehicle, Limits limits, const std::vector<FlightStep>& steps) {
  const std::vector<FlightStep> own = steps_for(vehicle, steps);
  std::erase_if(limits.responses,
                [&own](const auto& response) { return !has_response(own, response.first); });
  return limits;
}

/// Each takes two of casd's links and an emulator of its own.
constexpr std::size_t kMostVehicles = 16;
constexpr std::size_t kLongestName = 24;  ///< it is a part of paths of sockets, which are short
constexpr double kFarthest_m = 10'000;

std::string parse_name(const base::ConfigNode& node, const std::vector<ScenarioVehicle>& before) {
  const base::ConfigNode key = node.at("name");
  const auto name = key.as<std::string>();
  const bool plain =
      std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
  if (name.empty() || name.size() > kLongestName || !plain) {
    key.fail("a vehicle's name is made of up to 24 letters, digits and underscores");
  }
  if (std::ranges::count(before, name, &ScenarioVehicle::name) > 0) {
    key.fail("two vehicles have the name '" + name + "'");
  }
  return name;
}

VehiclePose parse_pose(const base::ConfigNode& node) {
  return {.x_m = node.require_in("x_m", -kFarthest_m, kFarthest_m),
          .y_m = node.require_in("y_m", -kFarthest_m, kFarthest_m),
          .z_m = node.get_in("z_m", 0, -kFarthest_m, kFarthest_m),
          .yaw_deg = node.get_in("yaw_deg", VehiclePose{}.yaw_deg, -360, 360)};
}

void check_apart(const base::ConfigNode& node, const std::vector<ScenarioVehicle>& vehicles) {
  constexpr double kLeast_m = 1;  // two quadrotors that touch each other fly nowhere
  const ScenarioVehicle& last = vehicles.back();
  for (std::size_t i = 0; i + 1 < vehicles.size(); ++i) {
    const VehiclePose& other = vehicles[i].pose;
    if (std::hypot(last.pose.x_m - other.x_m, last.pose.y_m - other.y_m) >= kLeast_m) continue;
    node.at("pose").fail("stands less than 1 m from '" + vehicles[i].name + "'");
  }
}

/// A block for another program, which checks its keys.
base::ConfigNode handed_on(const base::ConfigNode& node, std::string_view key) {
  const std::optional<base::ConfigNode> block = node.find(key);
  if (!block) return base::ConfigNode::empty(std::string(key));
  block->mark_used();
  return *block;
}

/// Reads the block `sensors`, if there is one. @throws base::ConfigError for an unknown set
base::ConfigNode parse_sensors(const base::ConfigNode& node) {
  const base::ConfigNode sensors = handed_on(node, "sensors");
  if (node.has("sensors")) base::sensor_set(sensors);  // for its errors, here
  return sensors;
}

ScenarioVehicle parse_alone(const base::ConfigNode& root) {
  ScenarioVehicle vehicle;
  vehicle.vehicle = base::find_config(root.at("vehicle"));
  vehicle.system_id = base::Vehicle::load(vehicle.vehicle).system_id;
  if (const auto pose = root.find("pose")) vehicle.pose = parse_pose(*pose);
  return vehicle;
}

ScenarioVehicle parse_one(const base::ConfigNode& node,
                          const std::vector<ScenarioVehicle>& before) {
  ScenarioVehicle vehicle;
  vehicle.name = parse_name(node, before);
  vehicle.vehicle = base::find_config(node.at("vehicle"));
  vehicle.system_id = static_cast<std::uint8_t>(before.size() + 1);
  vehicle.pose = parse_pose(node.at("pose"));
  vehicle.controller = handed_on(node, "controller");
  if (node.has("sensors")) vehicle.sensors = parse_sensors(node);
  return vehicle;
}

/// Reads `vehicle`, or the list `vehicles`.
std::vector<ScenarioVehicle> parse_vehicles(const base::ConfigNode& root) {
  const std::optional<base::ConfigNode> list = root.find("vehicles");
  if (!list) return {parse_alone(root)};
  if (root.has("vehicle")) list->fail("a scenario has 'vehicle' or 'vehicles', not both");
  std::vector<ScenarioVehicle> vehicles;
  for (const base::ConfigNode& node : list->items()) {
    vehicles.push_back(parse_one(node, vehicles));
    check_apart(node, vehicles);
  }
  if (vehicles.size() < 2) list->fail("is a list of two or more; for one there is 'vehicle: FILE'");
  if (vehicles.size() > kMostVehicles) list->fail("a run has at most 16 vehicles");
  return vehicles;
}

/// Reads the limits of each vehicle of several; one alone has those of the scenario.
void parse_vehicle_limits(const base::ConfigNode& root, const std::vector<FlightStep>& steps,
                          std::vector<ScenarioVehicle>& vehicles) {
  const std::optional<base::ConfigNode> list = root.find("vehicles");
  if (!list) return;
  const std::optional<base::ConfigNode> all = root.find("limits");
  const std::vector<base::ConfigNode> nodes = list->items();
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    base::ConfigNode limits = all ? *all : base::ConfigNode::empty("limits");
    if (const auto own = nodes[i].find("limits")) limits = own->merged_over(limits);
    vehicles[i].limits = limits_for(i, parse_limits(limits, steps), steps);
  }
}

constexpr int kSchema = 1;

base::Geodetic parse_home(const base::ConfigNode& node) {
  return {.lat_deg = node.require_in("lat_deg", -90, 90),
          .lon_deg = node.require_in("lon_deg", -180, 180),
          .alt_m = node.require_in("alt_m", -500, 9000)};
}

/// Reads `world`, `model_path` and `missing`. @throws base::ConfigError when there is no such file
ScenarioWorld parse_world(const base::ConfigNode& root) {
  ScenarioWorld world;
  const std::optional<base::ConfigNode> node = root.find("world");
  if (!node) return world;
  if (!node->is_scalar()) {
    node->fail("is the name of an SDF file; without it a scenario has flat ground");
  }
  world.sdf = base::find_config(*node);
  for (const auto& folder : root.get("model_path", std::vector<std::string>{})) {
    world.model_path.push_back(std::filesystem::weakly_canonical(root.resolve(folder)));
  }
  const auto missing = root.get<std::string>("missing", "error");
  if (missing != "error" && missing != "ignore") root.at("missing").fail("is error or ignore");
  world.ignore_missing = missing == "ignore";
  return world;
}

Rates parse_rates(const base::ConfigNode& node) {
  return {.sensor_hz = node.require_in("sensor_hz", 50, 2000),
          .gps_hz = node.require_in("gps_hz", 1, 50),
          .controls_hz = node.require_in("controls_hz", 50, 2000)};
}

void check_integrator(const base::ConfigNode& root, const Scenario& scenario) {
  if (scenario.integrator != "rk4" && scenario.integrator != "ode") {
    root.at("integrator").fail("the integrator is rk4 or ode");
  }
}

}  // namespace

std::map<std::string, double> parse_axes(const base::ConfigNode& limits, std::string_view key) {
  std::map<std::string, double> axes;
  const std::optional<base::ConfigNode> node = limits.find(key);
  if (!node) return axes;
  for (const std::string_view axis : {"x_m", "y_m", "z_m", "yaw_rad"}) {
    if (node->has(axis)) axes[std::string(axis)] = node->require_in(axis, 0, 1e6);
  }
  return axes;
}

void check_gusts(const std::vector<base::ConfigNode>& plugins, const ScenarioFaults& faults) {
  const bool has_wind = std::ranges::any_of(plugins, [](const base::ConfigNode& plugin) {
    return plugin.get<std::string>("plugin", "") == "wind";
  });
  if (has_wind) return;
  for (const VehicleFault& fault : faults.vehicle) {
    if (const auto gust = fault.script.find("gust")) {
      gust->fail("a gust needs 'plugin: wind' in the scenario's plugins");
    }
  }
}

double ScenarioVehicle::start_yaw_rad() const {
  constexpr double kNorthDeg = 90;
  return std::remainder((kNorthDeg - pose.yaw_deg) * M_PI / 180.0, 2 * M_PI);
}

std::string_view to_string(Architecture architecture) {
  switch (architecture) {
    case Architecture::kDirect:
      return "direct";
    case Architecture::kSitl:
      return "sitl";
    case Architecture::kTs:
      return "ts";
    case Architecture::kLoop:
      return "loop";
    case Architecture::kTcas:
      return "tcas";
  }
  return "?";
}

std::string title_of(Architecture architecture) {
  std::string title(to_string(architecture));
  for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return title;
}

Architecture parse_architecture(std::string_view word) {
  for (const Architecture architecture : kArchitectures) {
    if (to_string(architecture) == word) return architecture;
  }
  std::vector<std::string_view> known;
  known.reserve(kArchitectures.size());
  for (const Architecture architecture : kArchitectures) known.push_back(to_string(architecture));
  throw base::ConfigError("there is no architecture '" + std::string(word) +
                          "'; there are direct, sitl, ts, loop and tcas" +
                          base::did_you_mean(word, known));
}

VehicleNames Scenario::names() const {
  VehicleNames names;
  names.reserve(vehicles.size());
  for (const ScenarioVehicle& vehicle : vehicles) names.push_back(vehicle.name);
  return names;
}

std::vector<std::uint8_t> Scenario::systems() const {
  std::vector<std::uint8_t> systems;
  for (const ScenarioVehicle& vehicle : vehicles) systems.push_back(vehicle.system_id);
  return systems;
}

const base::ConfigNode& Scenario::sensors_of(std::size_t vehicle) const {
  const std::optional<base::ConfigNode>& own = vehicles.at(vehicle).sensors;
  return own ? *own : sensors;
}

const Limits& Scenario::limits_of(std::size_t vehicle) const {
  const std::optional<Limits>& own = vehicles.at(vehicle).limits;
  return own ? *own : limits;
}

Scenario Scenario::load(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  if (root.require<int>("schema") != kSchema) root.at("schema").fail("this program reads schema 1");
  if (root.has("firmware")) {
    root.at("firmware")
        .fail(
            "only `hils run` flies stock firmware: here our controller flies, and "
            "each scenario with `vehicle` will do");
  }
  Scenario scenario;
  scenario.file = file;
  scenario.name = root.get<std::string>("name", file.stem().string());
  scenario.description = root.get<std::string>("description", "");
  scenario.vehicles = parse_vehicles(root);
  scenario.world = parse_world(root);
  if (const auto home = root.find("home")) scenario.home = parse_home(*home);
  if (!scenario.home && scenario.world.sdf.empty()) root.at("home");  // says that it is missing
  scenario.decimal_year = root.get_in("decimal_year", scenario.decimal_year, 2000, 2100);
  scenario.seed = root.get<std::uint64_t>("seed", scenario.seed);
  try {
    scenario.architecture = parse_architecture(root.get<std::string>("architecture", "tcas"));
  } catch (const base::ConfigError& error) {
    root.at("architecture").fail(error.what());
  }
  scenario.step_us = base::get_whole_in<int>(root, "step_us", scenario.step_us, 100, 10'000);
  scenario.integrator = root.get<std::string>("integrator", scenario.integrator);
  scenario.rates = parse_rates(root.at("rates"));
  scenario.line = handed_on(root, "line");
  scenario.controller = handed_on(root, "controller");
  scenario.sensors = parse_sensors(root);
  if (root.has("plugins")) {
    scenario.plugins = root.at("plugins").items();
    root.at("plugins").mark_used();
  }
  if (root.has("wake_up")) scenario.wake_up = parse_wake_up(root.at("wake_up"));
  scenario.drain_tick_ms = root.get_in("drain_tick_ms", scenario.drain_tick_ms, 0, 10);
  scenario.ground_station = root.get("ground_station", false);
  scenario.steps = parse_flight(root.at("steps"), casd::GainMap::shipped(), scenario.names());
  refuse_missions(root.at("steps"));
  if (root.has("faults")) {
    scenario.faults = parse_scenario_faults(root.at("faults"), scenario.line, scenario.names());
    refuse_faults(root.at("faults"), std::array<std::string_view, 2>{"pause", "cut"},
                  "is a fault of a flight of stock firmware");
    check_gusts(scenario.plugins, scenario.faults);
    check_fault_phases(root.at("faults"), scenario.steps);
  }
  if (root.has("limits")) scenario.limits = parse_limits(root.at("limits"), scenario.steps);
  parse_vehicle_limits(root, scenario.steps, scenario.vehicles);
  scenario.limits.allow = parse_allow(root);
  for (ScenarioVehicle& vehicle : scenario.vehicles) {
    if (vehicle.limits) vehicle.limits->allow = scenario.limits.allow;
  }
  root.reject_unused();
  check_integrator(root, scenario);
  return scenario;
}

}  // namespace cas::hils
