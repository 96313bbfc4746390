// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/fcu_config.hpp"

#include <tuple>

#include "base/config/geodetic_keys.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/key_table.hpp"
#include "base/config/sensor_set.hpp"
#include "base/suggestion.hpp"
#include "fcu/control/wing_airframe.hpp"
#include "fcu/line/line_keys.hpp"
#include "fcu/params/params.hpp"

namespace cas::fcu {
namespace {

constexpr int kSchema = 1;

using base::key;
using base::Range;
using base::ReadApart;
using base::Whole;
using base::Words;

constexpr Words<Pace, 2> kPaces{{{{"realtime", Pace::kRealtime}, {"lockstep", Pace::kLockstep}}},
                                "must be realtime or lockstep"};
constexpr Words<StampMode, 2> kStamps{
    {{{"message", StampMode::kMessage}, {"arrival", StampMode::kArrival}}},
    "must be message or arrival"};
constexpr Words<ActuatorMessage, 3> kActuators{
    {{{"auto", ActuatorMessage::kAuto},
      {"hil_controls", ActuatorMessage::kHilControls},
      {"hil_actuator_controls", ActuatorMessage::kHilActuatorControls}}},
    "must be auto, hil_controls or hil_actuator_controls"};

constexpr auto kPlaceKeys = base::geodetic_keys(-500, 20000);

/// `none`, or a place.
struct HomeHint : base::Block<base::Geodetic, decltype(kPlaceKeys)> {
  void read(const base::ConfigNode& node, std::optional<base::Geodetic>& hint) const {
    if (!node.is_scalar()) return Block::read(node, hint.emplace());
    if (node.as<std::string>() == "none") return hint.reset();
    node.fail("must be none or a map of lat_deg, lon_deg, alt_m");
  }
};

constexpr Whole kId{1, 250};

constexpr std::tuple kKeys{
    base::required(key<&FcuConfig::vehicle>("vehicle", ReadApart{"file"}, "vehicle file")),
    key<&FcuConfig::system_id>("system_id", kId, "of the vehicle in MAVLink", "the vehicle's"),
    key<&FcuConfig::component_id>("component_id", kId, "its component"),
    key<&FcuConfig::sensors>(
        "sensors", base::SensorSet{},
        "the [sensor set](../use/plugins.md#sensor-sets) with the data sheets for "
        "the estimator",
        "the vehicle's"),
    key<&FcuConfig::line>("line", base::Parsed<LineConfig::parse>{},
                          "the [serial line](#serial-line)", "ideal"),
    key<&FcuConfig::pace>("pace", kPaces,
                          "`lockstep`: telemetry, time-outs and failsafes run on the time of the "
                          "HIL_SENSOR stream ([simulator.md](../use/simulator.md#lockstep)); "
                          "`--lockstep` does the same"),
    key<&FcuConfig::stamp>("stamp", kStamps,
                           "time of a sensor sample: its own stamp, or its arrival, as with PX4 "
                           "in HITL"),
    key<&FcuConfig::actuators>(
        "actuators", kActuators,
        "`hil_controls` (U1..U4), `hil_actuator_controls` (each motor and servo); `auto`: the "
        "first for the four equal upright rotors of [HILS] Eq. (3), else the second"),
    key<&FcuConfig::control_rate_hz>("control_rate_hz", Range{10, 1000},
                                     "on the clock of HIL_SENSOR"),
    key<&FcuConfig::decimal_year>("decimal_year", Range{2025, 2030},
                                  "date of the magnetic field model"),
    key<&FcuConfig::home_hint>("home_hint", HomeHint{{kPlaceKeys}},
                               "origin of the local frame N; none: the first fixes, averaged at "
                               "rest"),
    key<&FcuConfig::seed>("seed", base::Count{}, "seed of the line's random numbers"),
    key<&FcuConfig::params>("params", ReadApart{"name -> number"},
                            "parameters with other values than their defaults, by PX4 name",
                            "none"),
};

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
  config.sensors = config.vehicle.sensors;
  config.system_id = config.vehicle.system_id;
  base::read_keys(node, kKeys, config);
  if (config.actuators == ActuatorMessage::kHilControls &&
      airframe_kind(config.vehicle) != AirframeKind::kMulticopter) {
    node.at("actuators")
        .fail(
            "HIL_CONTROLS moves no control surface: a vehicle with wings needs "
            "hil_actuator_controls, or auto");
  }
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

std::string controller_reference() {
  return base::key_table(kKeys, FcuConfig{}) + "\nIts `line`:\n\n" +
         base::key_table(kLineKeys, LineConfig{});
}

}  // namespace cas::fcu
