// SPDX-License-Identifier: BSD-3-Clause
// Vehicle::load(): the vehicle file, and the model's word where the file has none.
#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/angles.hpp"
#include "base/config/aero_file.hpp"
#include "base/config/file_kind.hpp"
#include "base/config/missing_keys.hpp"
#include "base/config/model_match.hpp"
#include "base/config/output_use.hpp"
#include "base/config/propulsion_file.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"

namespace cas::base {
namespace {

constexpr int kSchema = 1;
constexpr double kHuge = 1e9;  // upper end where only the sign is checked

// Small readers.

double non_negative(const ConfigNode& node, std::string_view key) {
  return node.require_in(key, 0.0, kHuge);
}

double degrees(const ConfigNode& node, std::string_view key, double low, double high) {
  return radians(node.require_in(key, low, high));
}

// The rotors.

/// What the rotor's blocks do not replace.
/// @param node  the rotor's keys over those of the block `rotor`
RotorParams parse_rotor_params(const ConfigNode& node, bool propeller, bool electric) {
  RotorParams rotor;
  if (!propeller) {
    rotor.thrust_coefficient = positive_value(node, "thrust_coefficient");
    rotor.torque_coefficient = positive_value(node, "torque_coefficient");
    rotor.radius_m = positive_value(node, "radius_m");
    rotor.zero_thrust_speed_m_s = non_negative(node, "zero_thrust_speed_m_s");
  }
  if (!electric) {
    rotor.omega_max_rad_s = positive_value(node, "omega_max_rad_s");
    rotor.time_constant_up_s = non_negative(node, "time_constant_up_s");
    rotor.time_constant_down_s = non_negative(node, "time_constant_down_s");
  }
  rotor.omega_idle_rad_s =
      node.require_in("omega_idle_rad_s", 0.0, electric ? kHuge : rotor.omega_max_rad_s);
  rotor.inertia_kg_m2 = non_negative(node, "inertia_kg_m2");
  rotor.drag_coefficient = non_negative(node, "drag_coefficient");
  rotor.rolling_moment_coefficient = non_negative(node, "rolling_moment_coefficient");
  rotor.reference_density_kg_m3 = non_negative(node, "reference_density_kg_m3");
  rotor.ground_effect = node.require_in("ground_effect", 0.0, 1.0);
  rotor.inflow_thrust_slope = node.get_in("inflow_thrust_slope", 0.0, 0.0, 10.0);
  rotor.flapping_gain = node.get_in("flapping_gain", 0.0, 0.0, 10.0);
  rotor.flapping_stiffness_nm_rad = node.get_in("flapping_stiffness_nm_rad", 0.0, 0.0, kHuge);
  rotor.esc_dead_time_s = node.get_in("esc_dead_time_s", 0.0, 0.0, 0.1);
  rotor.reversible = node.get("reversible", false);
  if (rotor.reversible && rotor.omega_idle_rad_s > 0) {
    node.at("omega_idle_rad_s").fail("must be 0 for a rotor that is `reversible`: it stands at 0");
  }
  if (rotor.inflow_thrust_slope > 0 && rotor.zero_thrust_speed_m_s > 0) {
    node.at("inflow_thrust_slope")
        .fail(
            "takes thrust by the axial airspeed, and so does zero_thrust_speed_m_s; set one to 0");
  }
  return rotor;
}

TiltServo parse_tilt(const ConfigNode& node) {
  TiltServo tilt;
  tilt.axis_B = unit_vector(node.at("axis_B"));
  tilt.min_rad = degrees(node, "min_deg", -90, 0);
  tilt.max_rad = degrees(node, "max_deg", 0, 90);
  if (node.has("middle_deg")) {
    tilt.middle_rad = degrees(node, "middle_deg", node.require<double>("min_deg"),
                              node.require<double>("max_deg"));
  }
  tilt.rate_rad_s = degrees(node, "rate_deg_s", 1, kHuge);
  tilt.time_constant_s = node.require_in("time_constant_s", 1e-3, 10);
  tilt.output = output_of(node.at("output"));
  return tilt;
}

Wake parse_wake(const ConfigNode& node, int lower, int count) {
  const ConfigNode key = node.at("in_wake_of");
  const int upper = key.as<int>() - 1;
  if (upper < 0 || upper >= count || upper == lower) {
    key.fail(fmt::format("must be the number of another rotor, 1 to {}", count));
  }
  return {.upper = upper, .thrust_share = node.require_in("wake_thrust_share", 0, 1)};
}

/// The coefficients of a motor plugin, as a vehicle file would have them.
ConfigNode keys_of(const ModelMotor& motor) {
  std::string yaml;
  for (const auto& [key, value] : motor.keys) yaml += fmt::format("{}: {:.17g}\n", key, value);
  if (motor.reversible) yaml += "reversible: true\n";
  return ConfigNode::parse(yaml, motor.place);
}

int parse_spin(const ConfigNode& node) {
  int spin = 0;
  try {
    spin = node.as<int>();
  } catch (const ConfigError&) {  // a word such as "ccw": the sentence below says more
  }
  if (spin != 1 && spin != -1) {
    node.fail(
        "must be 1 (counter-clockwise) or -1 (clockwise), seen from where the thrust points: "
        "from above, where the rotor points up");
  }
  return spin;
}

/// A rotor's item in the list; place and axis come later.
/// @param motor    has what the vehicle file lacks; nullptr: none
/// @param battery  of the vehicle
Rotor parse_rotor(const ConfigNode& item, const ConfigNode& common, const ModelMotor* motor,
                  int index, int count, const std::optional<BatteryParams>& battery) {
  Rotor rotor;
  rotor.params = parse_rotor_params(
      item.merged_over(motor != nullptr ? common.merged_over(keys_of(*motor)) : common),
      rotor_block(item, common, "propeller").has_value(),
      rotor_block(item, common, "electric").has_value());
  read_propeller(item, common, rotor);
  read_electric(item, common, battery, rotor);
  const bool by_motor = motor != nullptr && motor->spin && !item.has("spin");
  rotor.spin = by_motor ? *motor->spin : parse_spin(item.at("spin"));
  const auto output = item.find("output");
  rotor.output = output ? output_of(*output) : index;
  if (item.has("in_wake_of") || item.has("wake_thrust_share")) {
    rotor.wake = parse_wake(item, index, count);
  }
  if (const auto tilt = item.find("tilt")) rotor.tilt = parse_tilt(*tilt);
  return rotor;
}

void check_wakes(const ConfigNode& node, const std::vector<Rotor>& rotors) {
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    if (!rotors[i].wake || !rotors[static_cast<std::size_t>(rotors[i].wake->upper)].wake) continue;
    node.items()[i].at("in_wake_of").fail("names a rotor that is in a wake itself");
  }
}

/// Takes the outputs of rotors and tilt servos.
void take_outputs(const ConfigNode& node, const std::vector<Rotor>& rotors, OutputUse& outputs) {
  const std::vector<ConfigNode> items = node.items();
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    outputs.take(items[i], rotors[i].output);
    if (rotors[i].tilt) outputs.take(items[i].at("tilt"), rotors[i].tilt->output);
  }
}

/// The first of thrust, roll, pitch and yaw that four rotors do not give independently of those
/// before it: [HILS] Eq. (3) has no inverse then. Nothing where they give all four.
const char* missing_input(const Eigen::Matrix4d& mixer) {
  constexpr double kSame = 1e-6;  // files round places to less
  const std::array names{"thrust", "roll moment", "pitch moment", "yaw moment"};
  const double arm = mixer.middleRows<2>(1).cwiseAbs().maxCoeff();
  for (int axis = 0; axis < 4; ++axis) {
    Eigen::MatrixXd rows = mixer.topRows(axis + 1);
    const double scale = axis == 1 || axis == 2 ? arm : rows.row(axis).cwiseAbs().maxCoeff();
    if (rows.row(axis).norm() <= kSame * scale) return names[static_cast<std::size_t>(axis)];
    rows.rowwise().normalize();
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> decomposition(rows.transpose());
    decomposition.setThreshold(kSame);
    if (decomposition.rank() <= axis) return names[static_cast<std::size_t>(axis)];
  }
  return nullptr;
}

/// Four rotors without servos are mixed by the inverse of [HILS] Eq. (3), so there must be one.
void check_mixer(const ConfigNode& rotors, const Vehicle& vehicle) {
  if (vehicle.rotor_count() != 4 || std::ranges::any_of(vehicle.rotors, [](const Rotor& rotor) {
        return rotor.tilt.has_value();
      })) {
    return;
  }
  const char* const missing = missing_input(vehicle.mixing_matrix());
  if (missing == nullptr) return;
  rotors.fail(std::string("places and spins of the four rotors leave no independent ") + missing +
              ", so U1 to U4 cannot be mixed; four rotors must not stand in a row, nor may the "
              "spins of their sides or diagonals cancel");
}

// The rest.

ControlScales parse_scales(const ConfigNode& node) {
  ControlScales scales;
  scales.u1_max_n = positive_value(node, "u1_max_n");
  scales.u2_max_nm = positive_value(node, "u2_max_nm");
  scales.u3_max_nm = positive_value(node, "u3_max_nm");
  scales.u4_max_nm = positive_value(node, "u4_max_nm");
  return scales;
}

BodyDragParams parse_body_drag(const ConfigNode& node) {
  BodyDragParams drag;
  const ConfigNode area = node.at("area_m2");
  drag.area_m2 = area.as<Eigen::Vector3d>();
  if (!(drag.area_m2.minCoeff() >= 0 && drag.area_m2.maxCoeff() <= kHuge)) {
    area.fail("must be three numbers, none below 0");
  }
  if (const auto centre = node.find("centre_B_m")) drag.centre_B_m = centre->as<Eigen::Vector3d>();
  return drag;
}

std::uint8_t parse_system_id(const ConfigNode& node) {
  const int id = node.as<int>();
  if (id < 1 || id > 255) node.fail("must lie in [1, 255]");
  return static_cast<std::uint8_t>(id);
}

void check_schema(const ConfigNode& node) {
  const int schema = node.require<int>("schema");
  if (schema != kSchema) {
    node.at("schema").fail(fmt::format("is {}; this program reads schema {}", schema, kSchema));
  }
}

std::vector<ConfigNode> rotor_items(const ConfigNode& rotors) {
  std::vector<ConfigNode> items = rotors.items();
  if (items.empty() || items.size() > kMaxRotors) {
    rotors.fail(fmt::format("must list 1 to {} rotors", kMaxRotors));
  }
  return items;
}

/// Whether rotors have the block `electric`.
bool has_circuits(const ConfigNode& node, const ConfigNode& common) {
  return common.has("electric") ||
         std::ranges::any_of(rotor_items(node.at("rotors")),
                             [](const ConfigNode& item) { return item.has("electric"); });
}

void need_rotor_keys(const ConfigNode& node, const ConfigNode& common, const ModelMatch& model,
                     MissingKeys& missing) {
  const std::vector<ConfigNode> items = rotor_items(node.at("rotors"));
  std::vector<const ModelMotor*> motors;
  for (std::size_t i = 0; i < items.size(); ++i) {
    motors.push_back(model.motor_of(model.link_of(items[i], static_cast<int>(i) + 1)));
  }
  need_propulsion_keys(common, missing);
  for (const std::string_view key : kRotorKeys) {
    if (common.has(key)) continue;
    for (std::size_t i = 0; i < items.size(); ++i) {
      const ModelMotor* const motor = motors[i];
      if (items[i].has(key) || is_replaced(items[i], common, key) ||
          (motor != nullptr && motor->keys.contains(key))) {
        continue;
      }
      if (node.has("rotor")) {
        missing.add(common, key);
      } else {
        missing.add(node, "rotor." + std::string(key));
      }
      break;
    }
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    need_propulsion_keys(items[i], missing);
    if (motors[i] == nullptr || !motors[i]->spin) missing.need(items[i], "spin");
    if (!items[i].has("position_B_m") &&
        model.link_of(items[i], static_cast<int>(i) + 1) == nullptr) {
      missing.add(items[i], "position_B_m");
    }
    if (items[i].has("in_wake_of")) missing.need(items[i], "wake_thrust_share");
    if (items[i].has("wake_thrust_share")) missing.need(items[i], "in_wake_of");
    if (const auto tilt = items[i].find("tilt")) {
      for (const char* key :
           {"axis_B", "min_deg", "max_deg", "rate_deg_s", "time_constant_s", "output"}) {
        missing.need(*tilt, key);
      }
    }
  }
}

/// Every key that must be there and is not. @throws ConfigError naming them all
/// @param file  of the model
void check_missing(const ConfigNode& node, const ConfigNode& common, const ModelMatch& model,
                   const std::filesystem::path& file) {
  MissingKeys missing;
  for (const char* key : {"name", "system_id", "body_drag_linear_n_s_m", "rotors"}) {
    missing.need(node, key);
  }
  if (!node.has("sdf")) missing.need(node, "urdf");
  if (!model.has_mass()) {
    missing.need(node, "mass_kg");
    missing.need(node, "inertia_kg_m2");
  }
  if (node.has("rotors")) need_rotor_keys(node, common, model, missing);
  if (const auto scales = node.find("scales")) {
    for (const char* key : {"u1_max_n", "u2_max_nm", "u3_max_nm", "u4_max_nm"}) {
      missing.need(*scales, key);
    }
  }
  if (const auto drag = node.find("body_drag")) missing.need(*drag, "area_m2");
  if (const auto battery = node.find("battery")) {
    need_battery_keys(*battery, node.has("rotors") && has_circuits(node, common), missing);
  }
  const bool unread = !model.has_model() && !file.empty();
  missing.check(node, unread ? "; its model " + file.string() + " is not there" : "");
}

/// Says which keys of a rotor the motor plugin has given, once for those that gave the same.
class MotorNotes {
 public:
  void note(const ConfigNode& item, const ConfigNode& common, const ModelMotor& motor) {
    std::string keys;
    const auto add = [&](std::string_view key) {
      if (item.has(key) || common.has(key) || is_replaced(item, common, key)) return;
      keys += (keys.empty() ? "" : ", ") + std::string(key);
    };
    if (motor.spin && !item.has("spin")) add("spin");
    for (const auto& [key, value] : motor.keys) add(key);
    if (motor.reversible) add("reversible");
    if (!keys.empty()) places_[keys].push_back(motor.place);
  }
  void write(std::vector<std::string>& warnings) const {
    for (const auto& [keys, places] : places_) {
      warnings.push_back(fmt::format(
          "{}: the model's motor plugin gives {}, which the vehicle file does not have{}",
          places.front(), keys,
          places.size() > 1 ? fmt::format(", and so do {} more", places.size() - 1) : ""));
    }
  }

 private:
  std::map<std::string, std::vector<std::string>> places_;  // by the keys
};

void parse_rotors(const ConfigNode& node, const ConfigNode& common, const ModelMatch& model,
                  Vehicle& vehicle) {
  const std::vector<ConfigNode> items = rotor_items(node);
  std::vector<Rotor>& rotors = vehicle.rotors;
  std::vector<const ModelLink*> links;
  MotorNotes notes;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const int index = static_cast<int>(i);
    links.push_back(model.link_of(items[i], index + 1));
    const ModelMotor* const motor = model.motor_of(links.back());
    if (motor != nullptr) notes.note(items[i], common, *motor);
    rotors.push_back(parse_rotor(items[i], common, motor, index, static_cast<int>(items.size()),
                                 vehicle.battery));
    if (rotors.back().electric.has_value() != rotors.front().electric.has_value()) {
      items[i].fail(
          "has a motor of another kind than rotor 1: give all of them `electric`, or none");
    }
    model.place(items[i], links.back(), rotors.back());
  }
  notes.write(vehicle.warnings);
  model.settle_others(node, links, vehicle);
  check_wakes(node, rotors);
}

ModelParts parse_parts(const ConfigNode& node) {
  ModelParts parts;
  for (const auto& [name, use] : node.entries()) {
    const auto word = use.as<std::string>();
    if (word != "fixed" && word != "left_out") use.fail("must be fixed or left_out");
    parts[name] = word == "fixed" ? PartUse::kFixed : PartUse::kLeftOut;
  }
  return parts;
}

/// The model that the file names; nothing where it is not there.
std::optional<ModelBody> read_model(const ConfigNode& node, Vehicle& vehicle) {
  const auto urdf = node.find("urdf");
  const auto sdf = node.find("sdf");
  if (urdf && sdf) sdf->fail("is a second model beside 'urdf'; leave one out");
  if (const auto parts = node.find("parts")) vehicle.parts = parse_parts(*parts);
  if (!urdf && !sdf) return std::nullopt;
  const ConfigNode& key = urdf ? *urdf : *sdf;
  vehicle.urdf = node.resolve(key.as<std::string>());
  return read_model_body(vehicle.urdf, vehicle.parts);
}

}  // namespace

Vehicle Vehicle::load(const std::filesystem::path& file) {
  const ConfigNode node = ConfigNode::load(file);
  check_schema(node);
  expect_file(node, FileKind::kVehicle);
  Vehicle vehicle;
  const ModelMatch model(node, read_model(node, vehicle));
  const ConfigNode common = node.find("rotor").value_or(ConfigNode::empty(file.string()));
  check_missing(node, common, model, vehicle.urdf);

  vehicle.name = node.require<std::string>("name");
  vehicle.mass_kg = model.mass_kg();
  vehicle.inertia_kg_m2 = model.inertia_kg_m2();
  if (const auto battery = node.find("battery")) {
    vehicle.battery = read_battery(*battery, has_circuits(node, common));
  }
  parse_rotors(node.at("rotors"), common, model, vehicle);
  vehicle.settle_lags();
  OutputUse outputs;
  take_outputs(node.at("rotors"), vehicle.rotors, outputs);
  check_mixer(node.at("rotors"), vehicle);
  if (const auto aero = node.find("aero")) {
    std::vector<bool> tilts;
    for (const Rotor& rotor : vehicle.rotors) tilts.push_back(rotor.tilt.has_value());
    vehicle.aero = read_aero(*aero, outputs, tilts);
  }
  if (const auto scales = node.find("scales")) {
    vehicle.scales = parse_scales(*scales);
  } else {
    vehicle.scales = vehicle.control_scales();
  }
  vehicle.body_drag_linear_n_s_m = non_negative(node, "body_drag_linear_n_s_m");
  if (const auto drag = node.find("body_drag")) vehicle.body_drag = parse_body_drag(*drag);
  vehicle.system_id = parse_system_id(node.at("system_id"));
  if (const auto sensors = node.find("sensors")) {
    vehicle.sensors = sensor_set(*sensors);
  }
  node.reject_unused();
  return vehicle;
}

}  // namespace cas::base
