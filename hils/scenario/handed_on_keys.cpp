// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/handed_on_keys.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>

#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"
#include "fcu/core/fcu_config.hpp"
#include "hils/scenario/controller_parts.hpp"
#include "hils/scenario/simulation_parts.hpp"
#include "hils/scenario/yaml_text.hpp"
#include "plugins/airspeed/airspeed_model.hpp"
#include "plugins/barometer/barometer_model.hpp"
#include "plugins/gps/gps_model.hpp"
#include "plugins/imu/imu_model.hpp"
#include "plugins/magnetometer/magnetometer_model.hpp"

namespace cas::hils {

namespace {

struct SensorReader {
  const char* plugin;
  void (*read)(const base::ConfigNode& block, double step_s);
};

constexpr std::array<SensorReader, 5> kSensorReaders{
    {{"imu", [](const auto& block, double step_s) { sim::parse_imu_params(block, step_s); }},
     {"gps", [](const auto& block, double step_s) { sim::parse_gps_params(block, step_s); }},
     {"magnetometer",
      [](const auto& block, double step_s) { sim::parse_magnetometer_params(block, step_s); }},
     {"barometer",
      [](const auto& block, double step_s) { sim::parse_barometer_params(block, step_s); }},
     {"airspeed",
      [](const auto& block, double step_s) { sim::parse_airspeed_params(block, step_s); }}}};

/// A key that hils itself writes into another program's file, and the source of its value.
struct OwnKey {
  std::string_view key;
  std::string_view source;
};

constexpr std::array<OwnKey, 8> kControllerKeys{
    {{"schema", "always 1"},
     {"vehicle", "the scenario's 'vehicle'"},
     {"system_id", "the vehicle's, or its place in 'vehicles'"},
     {"decimal_year", "the scenario's 'decimal_year'"},
     {"control_rate_hz", "the scenario's 'rates.controls_hz'"},
     {"seed", "the scenario's 'seed', or --seed"},
     {"pace", "the run's, by --lockstep"},
     {"line", "the scenario's 'line'"}}};

void refuse_own(const base::ConfigNode& key, std::string_view source) {
  key.fail(fmt::format("hils sets this key: its value is {}", source));
}

/// Whether a block of sensors or of the controller has keys.
/// @throws base::ConfigError for a block that is neither empty nor a map
bool has_keys(const base::ConfigNode& block) {
  if (block.is_null()) return false;
  block.entries();
  return true;
}

/// Reads a sensor set with the readers of the plugins.
/// @param behind  the vehicle's own sensors
/// @param over  blocks of the plugins that replace keys of the set
void read_sensors(const base::ConfigNode& set_or_keys, const base::ConfigNode& behind,
                  const base::ConfigNode& over, double step_s) {
  const base::ConfigNode set = over.merged_over(base::sensor_set(set_or_keys, behind));
  for (const auto& [plugin, read] : kSensorReaders) {
    const auto block = set.find(plugin);
    if (!block) continue;
    read(*block, step_s);
    block->reject_unused();
  }
}

/// Refuses sensors that the vehicle has no plugin for. @param plugins  of the vehicle
void refuse_others(const base::ConfigNode& keys, const std::set<std::string>& plugins) {
  if (keys.is_scalar() || !has_keys(keys)) return;
  for (const auto& [name, block] : keys.entries()) {
    if (name == "preset" || plugins.contains(name)) continue;
    block.fail("the vehicle has no plugin '" + name + "'");
  }
}

void refuse_rate(const base::ConfigNode& keys, const char* plugin, std::string_view source) {
  const auto block = keys.is_map() ? keys.find(plugin) : std::nullopt;
  if (!block || !block->is_map() || !block->has("rate_hz")) return;
  refuse_own(block->at("rate_hz"), source);
}

void check_sensors(const Scenario& scenario, std::size_t vehicle,
                   const std::set<std::string>& plugins, const base::ConfigNode& behind) {
  const base::ConfigNode& keys = scenario.sensors_of(vehicle);
  refuse_others(keys, plugins);
  refuse_rate(keys, "imu", "the scenario's 'rates.sensor_hz'");
  refuse_rate(keys, "gps", "the scenario's 'rates.gps_hz'");
  const auto rates =
      base::ConfigNode::parse(fmt::format("{{imu: {{rate_hz: {}}}, gps: {{rate_hz: {}}}}}",
                                          scenario.rates.sensor_hz, scenario.rates.gps_hz),
                              scenario.file.string());
  read_sensors(keys, behind, rates, scenario.step_us * 1e-6);
}

void refuse_own_keys(const base::ConfigNode& controller) {
  if (!has_keys(controller)) return;
  for (const auto& [key, source] : kControllerKeys) {
    if (const auto own = controller.find(key)) refuse_own(*own, source);
  }
}

void check_controller(const Scenario& scenario, std::size_t vehicle,
                      const base::ConfigNode& behind) {
  for (const base::ConfigNode& keys :
       {scenario.controller, scenario.vehicles.at(vehicle).controller}) {
    refuse_own_keys(keys);
    if (keys.is_null()) continue;
    if (const auto sheets = keys.find("sensors")) {
      constexpr double kNoStep = 0;  // the estimator has none
      read_sensors(*sheets, behind, base::ConfigNode::empty(), kNoStep);
    }
  }
  const std::string text = to_text(controller_node(scenario, vehicle));
  fcu::FcuConfig::parse(base::ConfigNode::parse(text + controller_origins(scenario, vehicle),
                                                scenario.file.string()));
}

/// Names of the scenario's plugins. @throws base::ConfigError for one that each vehicle has anyway
std::set<std::string> further_plugins(const Scenario& scenario) {
  for (const base::ConfigNode& plugin : scenario.plugins) {
    const base::ConfigNode name = plugin.at("plugin");
    const auto word = name.as<std::string>();
    if (word != "mavlink_interface" && word != kAeroPlugin &&
        std::ranges::find(kFirstPlugins, word) == kFirstPlugins.end())
      continue;
    name.fail((word == kAeroPlugin ? "each vehicle with wings" : "each vehicle") +
              std::string(" has plugin ") + word + " already" +
              (word == kFirstPlugins.front() || word == "mavlink_interface" || word == kAeroPlugin
                   ? ""
                   : "; its keys are those of 'sensors: {" + word + ": ...}'"));
  }
  return plugin_names(scenario.plugins);
}

}  // namespace

void check_handed_on_keys(const Scenario& scenario) {
  fcu::LineConfig::parse(scenario.line);
  std::set<std::string> plugins = further_plugins(scenario);
  plugins.insert(kFirstPlugins.begin(), kFirstPlugins.end());
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    const auto sheets = base::Vehicle::load(scenario.vehicles[i].vehicle).sensors;
    check_sensors(scenario, i, plugins, sheets);
    check_controller(scenario, i, sheets);
  }
}

void check_firmware_sensors(const Scenario& scenario) {
  const auto simulated = scenario.firmware->world.at("vehicles").items();
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    const auto& own = scenario.vehicles[i].sensors;
    const auto& keys = own ? own : scenario.firmware->sensors;
    if (!keys) continue;
    base::sensor_set(*keys);
    std::set<std::string> plugins = plugin_names(simulated.at(i).at("plugins").items());
    plugins.merge(plugin_names(scenario.plugins));
    refuse_others(*keys, plugins);
  }
}

}  // namespace cas::hils
