// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/fault/fault_spec.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <ranges>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "base/angles.hpp"
#include "base/config/axes.hpp"
#include "base/config/config_whole.hpp"
#include "base/config/sensor_names.hpp"
#include "base/earth/frames.hpp"
#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "plugins/common/satellite_signals.hpp"

namespace cas::sim {

using base::ConfigNode;

namespace {

constexpr double kLongestRun = 1e6;  // s
constexpr std::string_view kExternalAhrs = "external_ahrs";

struct FieldName {
  SensorTopic topic;
  const char* name;
  const char* unit;
  double to_si;
  SampleField field;
};

constexpr std::array<FieldName, 14> kFields{
    {{SensorTopic::kImu, "specific_force", "m_s2", 1.0, SampleField::kSpecificForce},
     {SensorTopic::kImu, "angular_rate", "deg_s", base::kRadPerDeg, SampleField::kAngularRate},
     {SensorTopic::kGps, "position", "m", 1.0, SampleField::kPosition},
     {SensorTopic::kGps, "velocity", "m_s", 1.0, SampleField::kVelocity},
     {SensorTopic::kMagnetometer, "field", "gauss", 1.0, SampleField::kField},
     {SensorTopic::kBarometer, "pressure", "pa", 1.0, SampleField::kPressure},
     {SensorTopic::kBarometer, "temperature", "degc", 1.0, SampleField::kTemperature},
     {SensorTopic::kRangefinder, "distance", "m", 1.0, SampleField::kDistance},
     {SensorTopic::kAirspeed, "differential_pressure", "pa", 1.0,
      SampleField::kDifferentialPressure},
     {SensorTopic::kOpticalFlow, "flow", "rad", 1.0, SampleField::kFlow},
     {SensorTopic::kOdometry, "position", "m", 1.0, SampleField::kPosition},
     {SensorTopic::kOdometry, "velocity", "m_s", 1.0, SampleField::kVelocity},
     {SensorTopic::kOdometry, "attitude", "deg", base::kRadPerDeg, SampleField::kAttitude},
     {SensorTopic::kLandingTarget, "angles", "deg", base::kRadPerDeg, SampleField::kAngles}}};

/// In the order of SensorTopic; also the names of their plugins.
constexpr std::array<std::string_view, 9> kSensorWords{
    "imu",      "gps",          "magnetometer", "barometer",     "rangefinder",
    "airspeed", "optical_flow", "odometry",     "landing_target"};

/// A fault of the sensor that the word means: "imu", or "imu_2".
SensorFault sensor_fault(const ConfigNode& node, SensorEffect effect) {
  const auto word = node.as<std::string>();
  const auto sensor = base::parse_sensor_name(word);
  const auto found =
      std::ranges::find(kSensorWords, sensor ? sensor->plugin : std::string_view(word));
  if (found == kSensorWords.end()) {
    node.fail(
        "must be imu, gps, magnetometer, barometer, rangefinder, airspeed, optical_flow, "
        "odometry or landing_target, or one of several: imu_2" +
        base::did_you_mean(word, kSensorWords));
  }
  SensorFault fault;
  fault.effect = effect;
  fault.topic = static_cast<SensorTopic>(found - kSensorWords.begin());
  fault.number = sensor ? sensor->number : 1;
  return fault;
}

/// {sensor: imu, angular_rate_deg_s: [1, 0, 0]}; a scale has no unit: {sensor: imu, angular_rate:
/// 2}; that of a drift is per second: {sensor: gps, position_m_s: [0.5, 0, 0]}.
SensorFault parse_change(const ConfigNode& node, SensorEffect effect,
                         BiasDriver driver = BiasDriver::kOne) {
  SensorFault fault = sensor_fault(node.at("sensor"), effect);
  fault.driver = driver;
  std::string known;
  for (const FieldName& entry : kFields) {
    if (entry.topic != fault.topic) continue;
    const bool has_unit = effect != SensorEffect::kScale;
    const std::string key = entry.name +
                            (has_unit ? std::string("_") + entry.unit : std::string()) +
                            (driver == BiasDriver::kTime ? "_s" : "");
    known += (known.empty() ? "" : " or ") + key;
    const auto value = node.find(key);
    if (!value) continue;
    fault.field = entry.field;
    fault.value = parse_axes(*value) * (has_unit ? entry.to_si : 1.0);
    return fault;
  }
  node.fail("needs " + known);
}

/// `freeze: imu`, or {sensor: imu, field: angular_rate}: one part of the sample alone.
SensorFault parse_freeze(const ConfigNode& node) {
  SensorFault fault = sensor_fault(node.is_map() ? node.at("sensor") : node, SensorEffect::kFreeze);
  if (!node.is_map()) return fault;
  const ConfigNode field = node.at("field");
  const auto word = field.as<std::string>();
  std::string known;
  for (const FieldName& entry : kFields) {
    if (entry.topic != fault.topic) continue;
    if (word == entry.name) fault.only = entry.field;
    known += (known.empty() ? "" : " or ") + std::string(entry.name);
  }
  if (!fault.only) field.fail("must be " + known);
  return fault;
}

/// `drop: imu`, or {sensor: imu, share: 0.5}, by chance, or {sensor: imu, all_but: 10}: each tenth
/// sample passes.
SensorFault parse_drop(const ConfigNode& node) {
  constexpr int kMost = 100'000;
  SensorFault fault = sensor_fault(node.is_map() ? node.at("sensor") : node, SensorEffect::kDrop);
  if (!node.is_map()) return fault;
  if (node.has("share") == node.has("all_but")) node.fail("needs share or all_but, not both");
  fault.drop_share = node.get_in("share", 1, 0, 1);
  fault.all_but = base::get_whole_in<int>(node, "all_but", 0, 2, kMost);
  return fault;
}

SensorFault parse_delay(const ConfigNode& node) {
  constexpr double kLongestDelay = 5;
  SensorFault fault = sensor_fault(node.at("sensor"), SensorEffect::kDelay);
  fault.delay = base::from_seconds(node.require_in("by_s", 0, kLongestDelay));
  return fault;
}

SensorFault parse_clip(const ConfigNode& node) {
  SensorFault fault = parse_change(node, SensorEffect::kClip);
  if ((fault.value.array() < 0.0).any()) node.fail("is clipped at 0 or above");
  return fault;
}

/// Magnetic field of the rotors' supply current, at their power in a hover.
SensorFault parse_current(const ConfigNode& node) {
  SensorFault fault = parse_change(node, SensorEffect::kBias, BiasDriver::kPower);
  if (fault.topic != SensorTopic::kMagnetometer) node.at("sensor").fail("must be magnetometer");
  return fault;
}

/// {sensor: barometer, pressure_coefficient: -0.3}: of the air's dynamic pressure.
SensorFault parse_airflow(const ConfigNode& node) {
  SensorFault fault = sensor_fault(node.at("sensor"), SensorEffect::kBias);
  fault.driver = BiasDriver::kDynamicPressure;
  fault.field = SampleField::kPressure;
  if (fault.topic != SensorTopic::kBarometer) node.at("sensor").fail("must be barometer");
  fault.value.x() = node.require_in("pressure_coefficient", -10, 10);
  return fault;
}

/// Shaking by the rotors: the amplitude of one that turns as in a hover.
SensorFault parse_vibration(const ConfigNode& node) {
  SensorFault fault = parse_change(node, SensorEffect::kBias, BiasDriver::kVibration);
  if (fault.topic != SensorTopic::kImu) node.at("sensor").fail("must be imu");
  return fault;
}

/// `blind: optical_flow`, odometry or landing_target.
SensorFault parse_blind(const ConfigNode& node) {
  SensorFault fault = sensor_fault(node, SensorEffect::kBlind);
  if (fault.topic != SensorTopic::kOpticalFlow && fault.topic != SensorTopic::kOdometry &&
      fault.topic != SensorTopic::kLandingTarget) {
    node.fail("must be optical_flow, odometry or landing_target");
  }
  return fault;
}

/// {position_m: [2, 0, 0], yaw_deg: 10}: of odometry, as by a loop that it closes.
SensorFault parse_relocated(const ConfigNode& node) {
  SensorFault fault;
  fault.effect = SensorEffect::kRelocate;
  fault.topic = SensorTopic::kOdometry;
  if (const auto position = node.find("position_m")) fault.value = parse_axes(*position);
  const double yaw_rad = base::radians(node.get_in("yaw_deg", 0, -360, 360));
  if (fault.value.isZero(0.0) && yaw_rad == 0) node.fail("needs position_m or yaw_deg");
  fault.turn = base::quaternion_rpy(0, 0, yaw_rad).toRotationMatrix();
  return fault;
}

/// Turned axes of one of the sensors whose samples are vectors of the body.
SensorFault turned_sensor(const ConfigNode& node) {
  SensorFault fault = sensor_fault(node, SensorEffect::kTurn);
  if (fault.topic != SensorTopic::kImu && fault.topic != SensorTopic::kMagnetometer) {
    node.fail("must be imu or magnetometer");
  }
  return fault;
}

/// {sensor: imu, rpy_deg: [0, 0, 90]}: mounting of the sensor in the vehicle. Angles are of D
/// (forward, right, down), samples of B (forward, left, up).
SensorFault parse_turn(const ConfigNode& node) {
  SensorFault fault = turned_sensor(node.at("sensor"));
  const Eigen::Vector3d rpy = node.require<Eigen::Vector3d>("rpy_deg").unaryExpr(&base::radians);
  const Eigen::Matrix3d R_DS = base::quaternion_rpy(rpy.x(), rpy.y(), rpy.z()).toRotationMatrix();
  const Eigen::Vector3d flip(1, -1, -1);
  fault.turn = flip.asDiagonal() * R_DS.transpose() * flip.asDiagonal();
  return fault;
}

/// {sensor: imu, from: [y, x, -z]}: the axis of B that each axis reads.
SensorFault parse_axis_map(const ConfigNode& node) {
  SensorFault fault = turned_sensor(node.at("sensor"));
  const ConfigNode from = node.at("from");
  const auto words = from.as<std::vector<std::string>>();
  if (words.size() != 3) from.fail("names three axes, such as [y, x, -z]");
  fault.turn.setZero();
  for (Eigen::Index row = 0; row < 3; ++row) {
    std::string_view word = words[static_cast<std::size_t>(row)];
    const double sign = word.starts_with('-') ? -1 : 1;
    if (word.starts_with('-')) word.remove_prefix(1);
    const std::size_t axis = std::string_view("xyz").find(word);
    if (word.size() != 1 || axis == std::string_view::npos) {
      from.fail("an axis is x, y or z, or one of them with a minus");
    }
    fault.turn(row, static_cast<Eigen::Index>(axis)) = sign;
  }
  return fault;
}

/// A fault of a receiver: of the first, without `sensor: gps_2`.
SensorFault receiver_fault(const ConfigNode& node, SensorEffect effect) {
  SensorFault fault;
  fault.effect = effect;
  fault.topic = SensorTopic::kGps;
  if (const auto sensor = node.find("sensor")) {
    fault = sensor_fault(*sensor, effect);
    if (fault.topic != SensorTopic::kGps) sensor->fail("must be gps or gps_2");
  }
  return fault;
}

/// {jammer_to_noise_db: 30, rise_s: 5}: C/N0 falls in proportion to the time.
SensorFault parse_jammed(const ConfigNode& node) {
  SensorFault fault = receiver_fault(node, SensorEffect::kJam);
  fault.loss_db = jammer_loss_db(node.require_in("jammer_to_noise_db", -20, 100));
  fault.rise_s = node.get_in("rise_s", 0, 0, kLongestRun);
  return fault;
}

/// {velocity_m_s: [2, 0, 0]}
SensorFault parse_spoofed(const ConfigNode& node) {
  SensorFault fault = receiver_fault(node, SensorEffect::kSpoof);
  fault.value = node.require<Eigen::Vector3d>("velocity_m_s");
  return fault;
}

/// {position_m: [3, 3, 5], time_constant_s: 30}
SensorFault parse_multipath(const ConfigNode& node) {
  SensorFault fault = receiver_fault(node, SensorEffect::kMultipath);
  fault.value = parse_axes(node.at("position_m"));
  if ((fault.value.array() < 0.0).any()) node.at("position_m").fail("is a deviation, 0 or above");
  fault.time_constant_s = node.require_in("time_constant_s", 0.001, kLongestRun);
  return fault;
}

SensorFault parse_fix(const ConfigNode& node) {
  SensorFault fault = receiver_fault(node, SensorEffect::kFix);
  fault.fix.type = static_cast<std::uint8_t>(base::get_whole_in<int>(node, "type", 3, 0, 8));
  fault.fix.satellites =
      static_cast<std::uint8_t>(base::get_whole_in<int>(node, "satellites", 10, 0, 60));
  fault.fix.eph_m = node.get_in("eph_m", fault.fix.eph_m, 0, 1e4);
  fault.fix.epv_m = node.get_in("epv_m", fault.fix.epv_m, 0, 1e4);
  return fault;
}

int parse_rotor_number(const ConfigNode& node) {
  const int rotor = node.as<int>() - 1;
  if (rotor < 0 || rotor >= base::kMaxRotors) {
    node.fail(fmt::format("must be 1 to {}", base::kMaxRotors));
  }
  return rotor;
}

SwapFault parse_swap(const ConfigNode& node) {
  const std::vector<ConfigNode> rotors = node.items();
  if (rotors.size() != 2) node.fail("names two rotors, such as [1, 3]");
  return {.first = parse_rotor_number(rotors[0]), .second = parse_rotor_number(rotors[1])};
}

RotorFault parse_rotor(const ConfigNode& node) {
  RotorFault fault;
  fault.rotor = parse_rotor_number(node.at("number"));
  if (node.get("stop", false)) fault.speed_share = 0;
  fault.stuck = node.get("stuck", false);
  if (fault.stuck && fault.speed_share == 0) {
    node.at("stuck").fail("a rotor stops or keeps its speed, not both");
  }
  fault.desync = node.get("desync", false);
  fault.thrust_share = node.get_in("thrust_share", 1, -1, 1);
  return fault;
}

/// {name: elevator, stuck: true}, or by its number in the vehicle file.
void parse_surface_name(const ConfigNode& node, SurfaceFault& fault) {
  if (node.has("name") == node.has("number")) node.fail("needs name or number, not both");
  fault.name = node.get<std::string>("name", "");
  if (node.has("number")) {
    fault.number = base::get_whole_in<int>(node, "number", 1, 1, base::kMaxOutputs) - 1;
  } else if (fault.name.empty()) {
    node.at("name").fail("is empty");
  }
}

SurfaceFault parse_surface(const ConfigNode& node) {
  constexpr double kFarthest_deg = 90;
  SurfaceFault fault;
  parse_surface_name(node, fault);
  int defects = 0;
  const auto flag = [&](const char* key, SurfaceDefect defect) {
    if (!node.get(key, false)) return;
    fault.defect = defect;
    ++defects;
  };
  flag("stuck", SurfaceDefect::kStuck);
  flag("reversed", SurfaceDefect::kReversed);
  flag("dead", SurfaceDefect::kDead);
  if (node.has("stuck_deg")) {
    fault.defect = SurfaceDefect::kHeld;
    fault.angle_rad = base::radians(node.require_in("stuck_deg", -kFarthest_deg, kFarthest_deg));
    ++defects;
  }
  if (node.has("rate_share")) {
    fault.defect = SurfaceDefect::kSlow;
    fault.rate_share = node.require_in("rate_share", 0, 1);
    ++defects;
  }
  if (defects != 1) node.fail("needs one of stuck, stuck_deg, reversed, dead, rate_share");
  return fault;
}

GustCommand parse_gust(const ConfigNode& node) {
  GustCommand gust;
  gust.amplitude_N_m_s = node.require<Eigen::Vector3d>("amplitude_m_s");
  gust.length_m = node.require_in("length_m", 0.1, 1e5);
  gust.hold_s = node.get_in("hold_s", 0, 0, kLongestRun);
  return gust;
}

/// `disconnect: external_ahrs`, the one unit with a line that can be cut.
LineCutFault parse_disconnect(const ConfigNode& node) {
  if (node.as<std::string>() != kExternalAhrs) node.fail("must be external_ahrs");
  return {};
}

/// What a fault can do, by its key.
struct Effect {
  std::string_view key;
  FaultKind (*parse)(const ConfigNode& node);
};

template <auto parse>
FaultKind kind_of(const ConfigNode& node) {
  return parse(node);
}

template <SensorEffect effect, BiasDriver driver = BiasDriver::kOne>
FaultKind change_of(const ConfigNode& node) {
  return parse_change(node, effect, driver);
}

template <class Fault, class Value>
FaultKind value_of(const ConfigNode& node) {
  return Fault{node.as<Value>()};
}

constexpr std::array<Effect, 27> kEffects{
    {{"freeze", kind_of<parse_freeze>},
     {"drop", kind_of<parse_drop>},
     {"delay", kind_of<parse_delay>},
     {"bias", change_of<SensorEffect::kBias>},
     {"scale", change_of<SensorEffect::kScale>},
     {"noise", change_of<SensorEffect::kNoise>},
     {"clip", kind_of<parse_clip>},
     {"drift", change_of<SensorEffect::kBias, BiasDriver::kTime>},
     {"current", kind_of<parse_current>},
     {"airflow", kind_of<parse_airflow>},
     {"vibration", kind_of<parse_vibration>},
     {"blind", kind_of<parse_blind>},
     {"relocated", kind_of<parse_relocated>},
     {"turn", kind_of<parse_turn>},
     {"axes", kind_of<parse_axis_map>},
     {"fix", kind_of<parse_fix>},
     {"jammed", kind_of<parse_jammed>},
     {"spoofed", kind_of<parse_spoofed>},
     {"multipath", kind_of<parse_multipath>},
     {"rotor", kind_of<parse_rotor>},
     {"swap_rotors", kind_of<parse_swap>},
     {"voltage_share", value_of<VoltageFault, double>},
     {"surface", kind_of<parse_surface>},
     {"mass_factor", value_of<MassFault, double>},
     {"cg_shift_B_m", value_of<CgFault, Eigen::Vector3d>},
     {"gust", kind_of<parse_gust>},
     {"disconnect", kind_of<parse_disconnect>}}};

/// The one thing that the fault does; the key says which.
FaultKind parse_kind(const ConfigNode& node) {
  std::optional<FaultKind> kind;
  for (const Effect& effect : kEffects) {
    const auto child = node.find(effect.key);
    if (!child) continue;
    if (kind) child->fail("is a second effect; give each its own entry");
    kind = effect.parse(*child);
  }
  if (kind) return *kind;
  std::string meant;  // where a key is nearly an effect
  for (const auto& [key, value] : node.entries()) {
    if (meant.empty()) {
      meant = base::did_you_mean(key, kEffects | std::views::transform(&Effect::key));
    }
  }
  node.fail("needs one of " + base::joined(kEffects, ", ", &Effect::key) + meant);
}

std::optional<Expression> parse_expression(const ConfigNode& node, const char* key) {
  const auto child = node.find(key);
  if (!child) return std::nullopt;
  try {
    return Expression::parse(child->as<std::string>());
  } catch (const std::invalid_argument& error) {
    child->fail(error.what());
  }
}

std::string degree_text(double angle_rad) {
  return fmt::format("{:.6g}", angle_rad * base::kDegPerRad);
}

/// Sentence of missing_part() for a surface.
std::string missing_surface(const SurfaceFault& fault, const base::Vehicle& vehicle) {
  const std::string whose = "vehicle '" + vehicle.name + "'";
  const auto index = fault.index_in(vehicle);
  if (!index) {
    std::string known;
    if (vehicle.aero) {
      known = base::joined(vehicle.aero->surfaces, ", ", &base::ControlSurface::name);
    }
    const std::string wanted =
        fault.name.empty() ? std::to_string(fault.number + 1) : "'" + fault.name + "'";
    return fmt::format("there is no surface {}; {} has {}", wanted, whose,
                       known.empty() ? "none" : known);
  }
  const base::ControlSurface& surface = vehicle.aero->surfaces[*index];
  const auto [low, high] = std::minmax(surface.min_rad, surface.max_rad);
  if (fault.defect != SurfaceDefect::kHeld || (fault.angle_rad >= low && fault.angle_rad <= high)) {
    return "";
  }
  return "surface '" + surface.name + "' of " + whose + " turns from " + degree_text(low) + " to " +
         degree_text(high) + " deg, not to " + degree_text(fault.angle_rad);
}

void check_shares(const ConfigNode& node, const FaultKind& kind) {
  if (const auto* voltage = std::get_if<VoltageFault>(&kind)) {
    if (voltage->share < 0 || voltage->share > 1)
      node.at("voltage_share").fail("must lie in [0, 1]");
  }
  if (const auto* mass = std::get_if<MassFault>(&kind)) {
    if (mass->factor <= 0.1 || mass->factor > 10)
      node.at("mass_factor").fail("must lie in [0.1, 10]");
  }
}

}  // namespace

std::string_view sensor_word(SensorTopic topic) {
  return kSensorWords[static_cast<std::size_t>(topic)];
}

std::string needed_plugin(const FaultKind& kind) {
  if (std::holds_alternative<GustCommand>(kind)) return "wind";
  if (std::holds_alternative<LineCutFault>(kind)) return std::string(kExternalAhrs);
  if (const auto* sensor = std::get_if<SensorFault>(&kind)) {
    return base::sensor_name(sensor_word(sensor->topic), sensor->number);
  }
  if (std::holds_alternative<SurfaceFault>(kind)) return "aero";
  return breaks_propulsion(kind) ? "motor" : "";
}

bool breaks_propulsion(const FaultKind& kind) {
  return std::holds_alternative<RotorFault>(kind) || std::holds_alternative<SwapFault>(kind) ||
         std::holds_alternative<VoltageFault>(kind);
}

std::optional<std::size_t> SurfaceFault::index_in(const base::Vehicle& vehicle) const {
  if (!vehicle.aero) return std::nullopt;
  const std::vector<base::ControlSurface>& surfaces = vehicle.aero->surfaces;
  const auto found = name.empty()
                         ? surfaces.begin() + std::min<std::ptrdiff_t>(number, std::ssize(surfaces))
                         : std::ranges::find(surfaces, name, &base::ControlSurface::name);
  if (found == surfaces.end()) return std::nullopt;
  return static_cast<std::size_t>(found - surfaces.begin());
}

std::string missing_part(const FaultKind& kind, const base::Vehicle& vehicle) {
  int rotor = -1;
  if (const auto* broken = std::get_if<RotorFault>(&kind)) rotor = broken->rotor;
  if (const auto* swapped = std::get_if<SwapFault>(&kind)) {
    rotor = std::max(swapped->first, swapped->second);
  }
  if (rotor >= vehicle.rotor_count()) {
    return fmt::format("there is no rotor {}; vehicle '{}' has {}", rotor + 1, vehicle.name,
                       vehicle.rotor_count());
  }
  const auto* of = std::get_if<SurfaceFault>(&kind);
  return of == nullptr ? "" : missing_surface(*of, vehicle);
}

FaultSpec parse_fault(const ConfigNode& node, std::size_t number) {
  FaultSpec fault;
  fault.name = node.get<std::string>("name", fmt::format("fault {}", number));
  fault.when = parse_expression(node, "when");
  fault.until = parse_expression(node, "until");
  if (node.has("at_s")) {
    fault.at = base::SimTime(base::from_seconds(node.require_in("at_s", 0, kLongestRun)));
  }
  if (node.has("for_s")) {
    fault.lasting = base::from_seconds(node.require_in("for_s", 0, kLongestRun));
  }
  if (fault.at.has_value() == fault.when.has_value()) node.fail("needs at_s or when, not both");
  if (fault.lasting && fault.until) node.fail("takes for_s or until, not both");
  fault.kind = parse_kind(node);
  check_shares(node, fault.kind);
  return fault;
}

std::vector<FaultSpec> parse_faults(const ConfigNode& node) {
  std::vector<FaultSpec> faults;
  for (const ConfigNode& item : node.at("faults").items()) {
    faults.push_back(parse_fault(item, faults.size() + 1));
  }
  return faults;
}

// Schedule.

FaultSchedule::FaultSchedule(std::vector<FaultSpec> faults)
    : faults_(std::move(faults)),
      scripted_(faults_.size()),
      states_(faults_.size()),
      since_(faults_.size()) {}

void FaultSchedule::reset() {
  faults_.erase(faults_.begin() + static_cast<std::ptrdiff_t>(scripted_), faults_.end());
  states_.assign(scripted_, State::kWaiting);
  since_.resize(scripted_);
}

void FaultSchedule::reserve(std::size_t further) { faults_.reserve(faults_.size() + further); }

void FaultSchedule::add(FaultSpec fault) {
  if (faults_.size() == faults_.capacity()) {
    throw base::ConfigError(fmt::format("a run takes no more faults by hand: {} were ordered",
                                        faults_.size() - scripted_));
  }
  faults_.push_back(std::move(fault));
  states_.push_back(State::kWaiting);
  since_.emplace_back();
}

void FaultSchedule::end(const std::string& name) {
  for (std::size_t i = scripted_; i < faults_.size(); ++i) {
    if (faults_[i].name != name) continue;
    if (states_[i] == State::kWaiting) states_[i] = State::kOver;
    if (states_[i] == State::kActive) states_[i] = State::kEnding;
  }
}

bool FaultSchedule::begins(const FaultSpec& fault, base::SimTime now, const Facts& facts) {
  return fault.at ? now >= *fault.at : fault.when->evaluate(facts);
}

bool FaultSchedule::ends(std::size_t fault, base::SimTime now, const Facts& facts) const {
  const FaultSpec& spec = faults_[fault];
  if (spec.lasting) return now - since_[fault] >= *spec.lasting;
  return spec.until && spec.until->evaluate(facts);
}

}  // namespace cas::sim
