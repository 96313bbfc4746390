// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/scenario.hpp"

#include <algorithm>

#include "base/config/config_whole.hpp"

namespace cas::hils {

namespace {

constexpr int kSchema = 1;

base::Geodetic parse_home(const base::ConfigNode& node) {
  return {.lat_deg = node.require_in("lat_deg", -90, 90),
          .lon_deg = node.require_in("lon_deg", -180, 180),
          .alt_m = node.require_in("alt_m", -500, 9000)};
}

WakeUpFigures parse_wake_up(const base::ConfigNode& node) {
  WakeUpFigures figures;
  figures.p50_us = node.require_in("p50_us", 0, 1e6);
  figures.p99_us = node.require_in("p99_us", figures.p50_us, 1e6);
  return figures;
}

Rates parse_rates(const base::ConfigNode& node) {
  return {.sensor_hz = node.require_in("sensor_hz", 50, 2000),
          .gps_hz = node.require_in("gps_hz", 1, 50),
          .controls_hz = node.require_in("controls_hz", 50, 2000)};
}

/// Plugin fault only asks for a gust; plugin wind blows it.
void check_gusts(const Scenario& scenario) {
  const bool has_wind = std::ranges::any_of(scenario.plugins, [](const base::ConfigNode& plugin) {
    return plugin.get<std::string>("plugin", "") == "wind";
  });
  if (has_wind) return;
  for (const VehicleFault& fault : scenario.faults.vehicle) {
    if (const auto gust = fault.script.find("gust")) {
      gust->fail("a gust needs 'plugin: wind' in the scenario's plugins");
    }
  }
}

void check_integrator(const base::ConfigNode& root, const Scenario& scenario) {
  if (scenario.integrator != "rk4" && scenario.integrator != "ode") {
    root.at("integrator").fail("the integrator is rk4 or ode");
  }
}

}  // namespace

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

Architecture parse_architecture(std::string_view word) {
  for (const Architecture architecture : kArchitectures) {
    if (to_string(architecture) == word) return architecture;
  }
  throw base::ConfigError("there is no architecture '" + std::string(word) +
                          "'; there are direct, sitl, ts, loop and tcas");
}

VehicleNames Scenario::names() const {
  VehicleNames names;
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
  Scenario scenario;
  scenario.file = file;
  scenario.name = root.get<std::string>("name", file.stem().string());
  scenario.description = root.get<std::string>("description", "");
  scenario.vehicles = parse_vehicles(root);
  scenario.home = parse_home(root.at("home"));
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
  if (root.has("faults")) {
    scenario.faults = parse_scenario_faults(root.at("faults"), scenario.line, scenario.names());
    check_gusts(scenario);
  }
  if (root.has("limits")) scenario.limits = parse_limits(root.at("limits"), scenario.steps);
  parse_vehicle_limits(root, scenario.steps, scenario.vehicles);
  root.reject_unused();
  check_integrator(root, scenario);
  return scenario;
}

}  // namespace cas::hils
