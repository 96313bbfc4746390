// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/fcu_config.hpp"

#include "base/config/config_whole.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/sensor_set.hpp"
#include "base/suggestion.hpp"
#include "fcu/params/params.hpp"

namespace cas::fcu {
namespace {

constexpr int kSchema = 1;

Pace parse_pace(const base::ConfigNode& node) {
  const auto word = node.get<std::string>("pace", "realtime");
  if (word == "realtime") return Pace::kRealtime;
  if (word == "lockstep") return Pace::kLockstep;
  node.at("pace").fail("must be realtime or lockstep");
}

StampMode parse_stamp(const base::ConfigNode& node) {
  const auto word = node.get<std::string>("stamp", "message");
  if (word == "message") return StampMode::kMessage;
  if (word == "arrival") return StampMode::kArrival;
  node.at("stamp").fail("must be message or arrival");
}

ActuatorMessage parse_actuators(const base::ConfigNode& node) {
  const auto word = node.get<std::string>("actuators", "auto");
  if (word == "auto") return ActuatorMessage::kAuto;
  if (word == "hil_controls") return ActuatorMessage::kHilControls;
  if (word == "hil_actuator_controls") return ActuatorMessage::kHilActuatorControls;
  node.at("actuators").fail("must be auto, hil_controls or hil_actuator_controls");
}

std::optional<base::Geodetic> parse_home_hint(const base::ConfigNode& node) {
  const auto hint = node.find("home_hint");
  if (!hint) return std::nullopt;
  if (hint->is_scalar()) {
    if (hint->as<std::string>() != "none")
      hint->fail("must be none or a map of lat_deg, lon_deg, alt_m");
    return std::nullopt;
  }
  return base::Geodetic{hint->require_in("lat_deg", -90, 90),
                        hint->require_in("lon_deg", -180, 180),
                        hint->require_in("alt_m", -500, 20000)};
}

std::uint8_t parse_id(const base::ConfigNode& node, std::string_view key, std::uint8_t fallback) {
  return base::get_whole_in<std::uint8_t>(node, key, fallback, 1, 250);
}

/// @throws base::ConfigError for a name or a value that the controller does not take
std::pair<std::string, double> parse_param(const std::string& name, const base::ConfigNode& node,
                                           ParamStore& store) {
  const auto value = node.as<double>();
  const ParamSetResult result = store.set(name, value);
  if (result == ParamSetResult::kUnknown) {
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < store.size(); ++i) known.emplace_back(store.at(i).name);
    node.fail("there is no parameter " + name + base::did_you_mean(name, known));
  }
  if (result != ParamSetResult::kOk) node.fail("is out of range");
  return {name, value};
}

}  // namespace

FcuConfig FcuConfig::parse(const base::ConfigNode& node) {
  if (node.require<int>("schema") != kSchema) node.at("schema").fail("must be 1");
  FcuConfig config;
  config.vehicle = base::Vehicle::load(base::find_config(node.at("vehicle")));
  const auto sensors = node.find("sensors");
  config.sensors = config.vehicle.sensors;
  if (sensors) config.sensors = base::sensor_set(*sensors, config.sensors);
  config.system_id = parse_id(node, "system_id", config.vehicle.system_id);
  config.component_id = parse_id(node, "component_id", 1);
  if (const auto line = node.find("line")) config.line = LineConfig::parse(*line);
  config.pace = parse_pace(node);
  config.stamp = parse_stamp(node);
  config.actuators = parse_actuators(node);
  config.control_rate_hz = node.get_in("control_rate_hz", 400, 10, 1000);
  config.decimal_year = node.get_in("decimal_year", 2026.5, 2025, 2030);
  config.home_hint = parse_home_hint(node);
  config.seed = node.get<std::uint64_t>("seed", 1);
  if (const auto params = node.find("params")) {
    ParamStore store(config.vehicle);
    for (const auto& [name, value] : params->entries()) {
      config.params.push_back(parse_param(name, value, store));
    }
  }
  node.reject_unused();
  return config;
}

FcuConfig FcuConfig::load(const std::filesystem::path& file) {
  return parse(base::ConfigNode::load(file));
}

}  // namespace cas::fcu
