// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario.hpp"

#include <algorithm>
#include <array>

#include "base/config_whole.hpp"
#include "base/install_paths.hpp"
#include "base/sensor_set.hpp"

namespace cas::hils {

namespace {

constexpr int kSchema = 1;
constexpr std::array<std::string_view, 4> kAxes{"x_m", "y_m", "z_m", "yaw_rad"};

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

std::map<std::string, double> parse_axes(const base::ConfigNode& limits, std::string_view key) {
  std::map<std::string, double> axes;
  const std::optional<base::ConfigNode> node = limits.find(key);
  if (!node) return axes;
  for (const std::string_view axis : kAxes) {
    if (node->has(axis)) axes[std::string(axis)] = node->require_in(axis, 0, 1e6);
  }
  return axes;
}

std::optional<double> optional_limit(const base::ConfigNode& node, std::string_view key,
                                     double most) {
  if (!node.has(key)) return std::nullopt;
  return node.require_in(key, 0, most);
}

/// Each key is the name of a `trajectory: {shape: step}` of the flight.
std::map<std::string, ResponseLimits> parse_responses(const base::ConfigNode& limits,
                                                      const std::vector<FlightStep>& steps) {
  std::map<std::string, ResponseLimits> responses;
  const std::optional<base::ConfigNode> node = limits.find("responses");
  if (!node) return responses;
  for (const auto& [name, body] : node->entries()) {
    const bool known = std::ranges::any_of(steps, [&name = name](const FlightStep& step) {
      return step.trajectory.shape == fcu::PatternShape::kSteps && phase_of(step) == name;
    });
    if (!known) body.fail("the flight has no 'trajectory: {shape: step}' of that name");
    responses[name] = {.rise_s = optional_limit(body, "rise_s", 1e6),
                       .overshoot_pct = optional_limit(body, "overshoot_pct", 1e6),
                       .settling_s = optional_limit(body, "settling_s", 1e6)};
  }
  return responses;
}

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

/// A block that is handed on to another program, which checks its keys.
base::ConfigNode handed_on(const base::ConfigNode& root, std::string_view key) {
  const std::optional<base::ConfigNode> node = root.find(key);
  if (!node) return base::ConfigNode::empty(std::string(key));
  node->mark_used();
  return *node;
}

/// Plugin fault only asks for a gust; plugin wind blows it.
void check_gusts(const Scenario& scenario) {
  const bool has_wind = std::ranges::any_of(scenario.plugins, [](const base::ConfigNode& plugin) {
    return plugin.get<std::string>("plugin", "") == "wind";
  });
  if (has_wind) return;
  for (const base::ConfigNode& fault : scenario.faults.vehicle) {
    if (const auto gust = fault.find("gust")) {
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

Scenario Scenario::load(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  if (root.require<int>("schema") != kSchema) root.at("schema").fail("this program reads schema 1");
  Scenario scenario;
  scenario.file = file;
  scenario.name = root.get<std::string>("name", file.stem().string());
  scenario.description = root.get<std::string>("description", "");
  scenario.vehicle = base::find_config(root.at("vehicle"));
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
  scenario.sensors = handed_on(root, "sensors");
  if (root.has("sensors")) base::sensor_set(scenario.sensors);  // for its errors, here
  if (root.has("plugins")) {
    scenario.plugins = root.at("plugins").items();
    root.at("plugins").mark_used();
  }
  if (root.has("wake_up")) scenario.wake_up = parse_wake_up(root.at("wake_up"));
  scenario.drain_tick_ms = root.get_in("drain_tick_ms", scenario.drain_tick_ms, 0, 10);
  scenario.ground_station = root.get("ground_station", false);
  scenario.steps = parse_flight(root.at("steps"), casd::GainMap::shipped());
  if (root.has("faults")) {
    scenario.faults = parse_scenario_faults(root.at("faults"), scenario.line);
    check_gusts(scenario);
  }
  if (root.has("limits")) scenario.limits = parse_limits(root.at("limits"), scenario.steps);
  root.reject_unused();
  check_integrator(root, scenario);
  return scenario;
}

}  // namespace cas::hils
