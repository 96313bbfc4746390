// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/handed_on_keys.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/sensor_names.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/topology/line_budget.hpp"
#include "fcu/core/fcu_config.hpp"
#include "hils/scenario/controller_parts.hpp"
#include "hils/scenario/simulation_parts.hpp"
#include "hils/scenario/yaml_text.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/odometry.hpp"
#include "mavlink/common/vision_position_estimate.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/imu/imu_model.hpp"

namespace cas::hils {

namespace {

struct SensorReader {
  const char* plugin;
  void (*read)(const base::ConfigNode& block, double step_s);
};

template <auto read>
void check(const base::ConfigNode& block, double step_s) {
  read(block, step_s);
}

constexpr std::array<SensorReader, 5> kSensorReaders{
    {{"imu", check<sim::parse_imu_params>},
     {"gps", check<sim::read_at_rate<base::read_gps_sheet>>},
     {"magnetometer", check<sim::read_at_rate<base::read_magnetometer_sheet>>},
     {"barometer", check<sim::read_at_rate<base::read_barometer_sheet>>},
     {"airspeed", check<sim::read_at_rate<base::read_airspeed_sheet>>}}};

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
    for (int number = 1; number <= base::most_sensors(plugin); ++number) {
      const std::string name = base::sensor_name(plugin, number);
      if (!set.has(name)) continue;
      const auto block = base::sensor_block(set, name);
      read(*block, step_s);
      block->reject_unused();
    }
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

/// Refuses a rate of the sensors of a kind, all of which have the scenario's.
void refuse_rate(const base::ConfigNode& keys, const char* plugin, std::string_view source) {
  for (int number = 1; number <= base::most_sensors(plugin); ++number) {
    const auto block = keys.is_map() ? keys.find(base::sensor_name(plugin, number)) : std::nullopt;
    if (!block || !block->is_map() || !block->has("rate_hz")) continue;
    refuse_own(block->at("rate_hz"), source);
  }
}

/// How often a vehicle's HIL_SENSOR of an id from 1 on is sent: with each sample of its IMU, else
/// of its faster sensor. @param number  of its sensors
double further_set_hz(const base::ConfigNode& set, int number, double sensor_hz) {
  if (set.has(base::sensor_name("imu", number))) return sensor_hz;
  double hz = 0;
  for (const char* plugin : {"magnetometer", "barometer"}) {
    const std::string name = base::sensor_name(plugin, number);
    if (set.has(name)) hz = std::max(hz, base::sensor_block(set, name)->get("rate_hz", 0.0));
  }
  return hz;
}

template <class Message>
casd::LineLoad load_of(double hz) {
  return {Message::kId, hz, mav::kHeaderBytesV2 + Message::kMaxLength + mav::kChecksumBytes};
}

/// The scenario's plugin odometry; end() without one.
auto find_odometry(const Scenario& scenario) {
  return std::ranges::find_if(scenario.plugins, [](const base::ConfigNode& plugin) {
    return plugin.at("plugin").as<std::string>() == "odometry";
  });
}

/// What a vehicle's odometry puts on its line; nullopt without one.
/// @param set  flown_sensors() of the vehicle
std::optional<casd::LineLoad> odometry_load(const Scenario& scenario, const base::ConfigNode& set) {
  const auto plugin = find_odometry(scenario);
  if (plugin == scenario.plugins.end()) return std::nullopt;
  const auto of_set = set.find("odometry");
  const base::ConfigNode keys = of_set ? plugin->merged_over(*of_set) : *plugin;
  const double hz = keys.get("rate_hz", 0.0);
  return keys.get<std::string>("message", "ODOMETRY") == "ODOMETRY"
             ? load_of<mavlink::common::Odometry>(hz)
             : load_of<mavlink::common::VisionPositionEstimate>(hz);
}

/// Refuses further sensors and odometry whose packets do not fit on the scenario's line beside the
/// first ones. @param set  flown_sensors() of a vehicle
void check_line_carries(const Scenario& scenario, const base::ConfigNode& set) {
  const double baud = fcu::LineConfig::parse(scenario.line).baud;
  const std::vector<std::string> further = further_first_sensors(set);
  const auto odometry = odometry_load(scenario, set);
  if ((further.empty() && !odometry) || baud <= 0) return;
  double hz = scenario.rates.sensor_hz;
  for (int number = 2; number <= base::most_sensors("imu"); ++number) {
    hz += further_set_hz(set, number, scenario.rates.sensor_hz);
  }
  const double fixes_hz = scenario.rates.gps_hz * (set.has("gps_2") ? 2 : 1);
  casd::LineBudget budget{.link = "line",
                          .baud = static_cast<unsigned>(baud),
                          .capacity_bytes_s = casd::LinePacer::kLineShare *
                                              casd::LinePacer::rate_of(static_cast<unsigned>(baud)),
                          .loads = {load_of<mavlink::common::HilSensor>(hz),
                                    load_of<mavlink::common::HilGps>(fixes_hz)}};
  if (odometry) budget.loads.push_back(*odometry);
  if (budget.fits()) return;
  const unsigned fitting = budget.fitting_baud();
  const base::ConfigNode at =
      further.empty() ? find_odometry(scenario)->at("plugin") : set.at(further.front());
  at.fail(
      fmt::format("with the further sensors the line carries {:.1f} kB/s of {:.1f}: "
                  "HIL_SENSOR {:g} and HIL_GPS {:g} a second{}; {}lower rates.sensor_hz",
                  budget.load_bytes_s() / 1e3, budget.capacity_bytes_s / 1e3, hz, fixes_hz,
                  odometry ? fmt::format(", odometry {:g}", odometry->hz) : "",
                  fitting > 0 ? fmt::format("it takes {} baud, or ", fitting) : ""));
}

void check_sensors(const Scenario& scenario, std::size_t vehicle,
                   const std::set<std::string>& plugins, const base::ConfigNode& behind) {
  const base::ConfigNode& keys = scenario.sensors_of(vehicle);
  const base::ConfigNode set = flown_sensors(scenario, vehicle);
  std::set<std::string> known = plugins;
  for (std::string& name : further_first_sensors(set)) known.insert(std::move(name));
  refuse_others(keys, known);
  check_line_carries(scenario, set);
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
    const int number = base::sensor_number(plugin, word);
    if (word != "mavlink_interface" && word != kAeroPlugin &&
        std::ranges::find(kFirstPlugins, word) == kFirstPlugins.end())
      continue;
    name.fail((word == kAeroPlugin ? "each vehicle with wings" : "each vehicle") +
              std::string(" has plugin ") + word + " already" +
              (word == kFirstPlugins.front() || word == "mavlink_interface" || word == kAeroPlugin
                   ? ""
                   : "; its keys are those of 'sensors: {" + base::sensor_name(word, number) +
                         ": ...}'"));
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
    const std::vector<std::string> further = base::further_sensors(base::sensor_set(*keys));
    if (scenario.firmware->on_serial_line && !further.empty()) {
      base::sensor_set(*keys)
          .at(further.front())
          .fail("PX4 takes each HIL_SENSOR of a serial line for one and the same IMU");
    }
    std::set<std::string> plugins = plugin_names(simulated.at(i).at("plugins").items());
    plugins.merge(plugin_names(scenario.plugins));
    refuse_others(*keys, plugins);
  }
}

}  // namespace cas::hils
