// SPDX-License-Identifier: BSD-3-Clause
// Vehicle::load(): the vehicle file, and the model's word where the file has none.
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "base/angles.hpp"
#include "base/config/model_body.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"

namespace cas::base {
namespace {

constexpr int kSchema = 1;
constexpr double kHuge = 1e9;  // upper end where only the sign is checked

// Two descriptions agree within the rounding of files.
constexpr double kSameMass = 1e-3;     // of it
constexpr double kSameInertia = 5e-3;  // of the largest moment
constexpr double kSamePlace_m = 5e-4;
constexpr double kSameAxis_rad = 5e-3;
constexpr double kUpright_rad = 1e-6;  // CAD programs write angles with a rounding error

constexpr std::array<std::string_view, 13> kRotorKeys{
    "thrust_coefficient",    "torque_coefficient",
    "omega_max_rad_s",       "omega_idle_rad_s",
    "time_constant_up_s",    "time_constant_down_s",
    "inertia_kg_m2",         "radius_m",
    "drag_coefficient",      "rolling_moment_coefficient",
    "zero_thrust_speed_m_s", "reference_density_kg_m3",
    "ground_effect"};

// Small readers.

double non_negative(const ConfigNode& node, std::string_view key) {
  return node.require_in(key, 0.0, kHuge);
}

double positive(const ConfigNode& node, std::string_view key) {
  const double value = node.require<double>(key);
  if (value <= 0.0) node.at(key).fail("must be above zero");
  return value;
}

double degrees(const ConfigNode& node, std::string_view key, double low, double high) {
  return radians(node.require_in(key, low, high));
}

Eigen::Vector3d unit_vector(const ConfigNode& node) {
  const Eigen::Vector3d axis = node.as<Eigen::Vector3d>();
  if (axis.norm() < 1e-9) node.fail("is a direction and must not be zero");
  return axis.normalized();
}

/// An output's index, from its number 1..16.
int output_of(const ConfigNode& node) {
  const int number = node.as<int>();
  if (number < 1 || number > kMaxOutputs) {
    node.fail("must lie in [1, " + std::to_string(kMaxOutputs) + "]");
  }
  return number - 1;
}

std::string text(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", value);
  return digits;
}

std::string text(const Eigen::Vector3d& v) {
  return "[" + text(v.x()) + ", " + text(v.y()) + ", " + text(v.z()) + "]";
}

/// Collects the keys that are not there, so that one sentence names them all.
class MissingKeys {
 public:
  void need(const ConfigNode& node, std::string_view key) {
    if (!node.find(key)) add(node, key);
  }
  void add(const ConfigNode& node, std::string_view key) {
    missing_.push_back({node, std::string(key)});
  }
  /// @throws ConfigError when there are any
  void check(const ConfigNode& root) const {
    if (missing_.empty()) return;
    if (missing_.size() == 1) static_cast<void>(missing_[0].node.at(missing_[0].key));
    std::string names;
    for (const Missing& each : missing_) {
      const std::string path = each.node.path();
      names += (names.empty() ? "'" : ", '") + path + (path.empty() ? "" : ".") + each.key + "'";
    }
    root.fail("keys are missing: " + names);
  }

 private:
  struct Missing {
    ConfigNode node;
    std::string key;
  };
  std::vector<Missing> missing_;
};

// The rotors.

RotorParams parse_rotor_params(const ConfigNode& node) {
  RotorParams rotor;
  rotor.thrust_coefficient = positive(node, "thrust_coefficient");
  rotor.torque_coefficient = positive(node, "torque_coefficient");
  rotor.omega_max_rad_s = positive(node, "omega_max_rad_s");
  rotor.omega_idle_rad_s = node.require_in("omega_idle_rad_s", 0.0, rotor.omega_max_rad_s);
  rotor.time_constant_up_s = non_negative(node, "time_constant_up_s");
  rotor.time_constant_down_s = non_negative(node, "time_constant_down_s");
  rotor.inertia_kg_m2 = non_negative(node, "inertia_kg_m2");
  rotor.radius_m = positive(node, "radius_m");
  rotor.drag_coefficient = non_negative(node, "drag_coefficient");
  rotor.rolling_moment_coefficient = non_negative(node, "rolling_moment_coefficient");
  rotor.zero_thrust_speed_m_s = non_negative(node, "zero_thrust_speed_m_s");
  rotor.reference_density_kg_m3 = non_negative(node, "reference_density_kg_m3");
  rotor.ground_effect = node.require_in("ground_effect", 0.0, 1.0);
  rotor.inflow_thrust_slope = node.get_in("inflow_thrust_slope", 0.0, 0.0, 10.0);
  rotor.flapping_gain = node.get_in("flapping_gain", 0.0, 0.0, 10.0);
  rotor.flapping_stiffness_nm_rad = node.get_in("flapping_stiffness_nm_rad", 0.0, 0.0, kHuge);
  rotor.esc_dead_time_s = node.get_in("esc_dead_time_s", 0.0, 0.0, 0.1);
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
  tilt.rate_rad_s = degrees(node, "rate_deg_s", 1, kHuge);
  tilt.time_constant_s = node.require_in("time_constant_s", 1e-3, 10);
  tilt.output = output_of(node.at("output"));
  return tilt;
}

Wake parse_wake(const ConfigNode& node, int lower, int count) {
  const ConfigNode key = node.at("in_wake_of");
  const int upper = key.as<int>() - 1;
  if (upper < 0 || upper >= count || upper == lower) {
    key.fail("must be the number of another rotor, 1 to " + std::to_string(count));
  }
  return {.upper = upper, .thrust_share = node.require_in("wake_thrust_share", 0, 1)};
}

/// A rotor's item in the list; place and axis come later.
Rotor parse_rotor(const ConfigNode& item, const ConfigNode& common, int index, int count) {
  Rotor rotor;
  rotor.params = parse_rotor_params(item.merged_over(common));
  rotor.spin = item.require<int>("spin");
  if (rotor.spin != 1 && rotor.spin != -1) {
    item.at("spin").fail(
        "must be 1 (counter-clockwise) or -1 (clockwise), seen from where the thrust points: "
        "from above, where the rotor points up");
  }
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

void check_outputs(const ConfigNode& node, const std::vector<Rotor>& rotors) {
  std::array<int, kMaxOutputs> users{};
  const auto take = [&](const ConfigNode& at, int output) {
    if (++users[static_cast<std::size_t>(output)] > 1) {
      at.fail("output " + std::to_string(output + 1) + " drives something else already");
    }
  };
  const std::vector<ConfigNode> items = node.items();
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    take(items[i], rotors[i].output);
    if (rotors[i].tilt) take(items[i].at("tilt"), rotors[i].tilt->output);
  }
}

// Values that the model file gives as well.

/// Holds the file's word against the model's, or takes the model's.
class Description {
 public:
  Description(const ConfigNode& node, std::optional<ModelBody> body)
      : node_(node), body_(std::move(body)) {}

  bool has_mass() const { return body_ && body_->mass_kg > 0; }

  double mass_kg() const {
    if (!node_.has("mass_kg")) return body_->mass_kg;
    const double mass = positive(node_, "mass_kg");
    if (has_mass() && std::abs(mass - body_->mass_kg) > kSameMass * mass) {
      differ(node_.at("mass_kg"), text(mass), body_->inertial_line, text(body_->mass_kg),
             "all links together");
    }
    return mass;
  }

  Eigen::Vector3d inertia_kg_m2() const {
    if (!node_.has("inertia_kg_m2")) {
      const Eigen::Vector3d model = body_->inertia_B_kg_m2.diagonal();
      if ((model.array() <= 0.0).any()) {
        node_.fail("key 'inertia_kg_m2' is missing, and " + at_line(body_->inertial_line) +
                   " has no inertia of a rigid body");
      }
      return model;
    }
    const ConfigNode key = node_.at("inertia_kg_m2");
    const Eigen::Vector3d inertia = key.as<Eigen::Vector3d>();
    if ((inertia.array() <= 0.0).any()) key.fail("must be above zero in each axis");
    if (2.0 * inertia.maxCoeff() > inertia.sum()) {
      key.fail("belongs to no rigid body: one moment exceeds the sum of the other two");
    }
    if (!has_mass()) return inertia;
    const Eigen::Vector3d model = body_->inertia_B_kg_m2.diagonal();
    if ((inertia - model).cwiseAbs().maxCoeff() > kSameInertia * inertia.maxCoeff()) {
      differ(key, text(inertia), body_->inertial_line, text(model),
             "all links together, about their centre of gravity");
    }
    return inertia;
  }

  /// The link that carries a rotor: the one that `link` names, else rotor_N (from rotor_0 on where
  /// there is one), else the turning link nearest to the place that the file gives. Nothing where
  /// the model has no such link.
  const ModelLink* link_of(const ConfigNode& item, int number) const {
    if (const auto key = item.find("link")) {
      const auto name = key->as<std::string>();
      const ModelLink* const link = body_ ? body_->find(name) : nullptr;
      if (link == nullptr) key->fail("the model has no link '" + name + "'" + turning_names());
      return link;
    }
    if (!body_) return nullptr;
    const int before_first = body_->find("rotor_0") != nullptr ? 1 : 0;  // as PX4's models count
    const std::string name = std::string("rotor_") + std::to_string(number - before_first);
    const ModelLink* const numbered = body_->find(name);
    if (numbered != nullptr && numbered->axis_R) return numbered;
    return item.has("position_B_m") ? nearest(item.require<Eigen::Vector3d>("position_B_m"))
                                    : nullptr;
  }

  void place(const ConfigNode& item, const ModelLink* link, Rotor& rotor) const {
    if (const auto key = item.find("position_B_m")) {
      rotor.position_B_m = key->as<Eigen::Vector3d>();
      if (link != nullptr) check_place(*key, *link, rotor.position_B_m);
    } else {
      rotor.position_B_m = body_->position_B_m(*link);
    }
    if (const auto key = item.find("axis_B")) {
      rotor.axis_B = unit_vector(*key);
      if (link != nullptr && link->axis_R) check_axis(*key, *link, rotor.axis_B);
    } else if (link != nullptr && link->axis_R) {
      rotor.axis_B = upward(*link->axis_R);
    }
  }

  /// Each link that turns is one rotor's.
  void check_all_listed(const ConfigNode& rotors,
                        const std::vector<const ModelLink*>& taken) const {
    for (std::size_t i = 0; i < taken.size(); ++i) {
      if (taken[i] == nullptr) continue;
      if (std::find(taken.begin(), taken.begin() + static_cast<std::ptrdiff_t>(i), taken[i]) !=
          taken.begin() + static_cast<std::ptrdiff_t>(i)) {
        rotors.items()[i].fail("its link '" + taken[i]->name + "' is another rotor's, too");
      }
    }
    if (!body_) return;
    for (const ModelLink& link : body_->links) {
      if (!link.axis_R || std::find(taken.begin(), taken.end(), &link) != taken.end()) continue;
      rotors.fail("lists " + std::to_string(taken.size()) + " rotors, but " + at_line(link.line) +
                  " has one more: link '" + link.name +
                  "' turns without end; list it, or make the joint fixed");
    }
  }

 private:
  std::string at_line(int line) const { return body_->file.string() + ":" + std::to_string(line); }

  [[noreturn]] void differ(const ConfigNode& key, const std::string& here, int line,
                           const std::string& there, const std::string& what) const {
    key.fail("is " + here + ", but " + at_line(line) + " has " + there + " (" + what +
             "); mend one, or leave this key out");
  }

  void check_place(const ConfigNode& key, const ModelLink& link, const Eigen::Vector3d& p_B) const {
    const Eigen::Vector3d model = body_->position_B_m(link);
    if ((p_B - model).norm() <= kSamePlace_m) return;
    differ(key, text(p_B), link.line, text(model),
           "link '" + link.name + "' from the centre of gravity, which is at " +
               text(body_->cog_R_m) + " of the model's frame");
  }

  void check_axis(const ConfigNode& key, const ModelLink& link, const Eigen::Vector3d& axis) const {
    // A joint's axis may point either way: the sense of turning is `spin`.
    if (axis.cross(*link.axis_R).norm() <= kSameAxis_rad) return;
    differ(key, text(axis), link.line, text(upward(*link.axis_R)), "link '" + link.name + "'");
  }

  static Eigen::Vector3d upward(const Eigen::Vector3d& axis) {
    if (axis.head<2>().norm() < kUpright_rad) return Eigen::Vector3d::UnitZ();
    return axis.z() < -kUpright_rad ? Eigen::Vector3d(-axis) : axis;
  }

  const ModelLink* nearest(const Eigen::Vector3d& p_B) const {
    const ModelLink* found = nullptr;
    for (const ModelLink& link : body_->links) {
      if (!link.axis_R) continue;
      const double distance = (body_->position_B_m(link) - p_B).norm();
      if (found == nullptr || distance < (body_->position_B_m(*found) - p_B).norm()) found = &link;
    }
    return found;
  }

  std::string turning_names() const {
    std::string names;
    if (body_) {
      for (const ModelLink& link : body_->links) {
        if (link.axis_R) names += (names.empty() ? "; those that turn are '" : "', '") + link.name;
      }
    }
    return names.empty() ? "" : names + "'";
  }

  ConfigNode node_;
  std::optional<ModelBody> body_;
};

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
  scales.u1_max_n = positive(node, "u1_max_n");
  scales.u2_max_nm = positive(node, "u2_max_nm");
  scales.u3_max_nm = positive(node, "u3_max_nm");
  scales.u4_max_nm = positive(node, "u4_max_nm");
  return scales;
}

BatteryParams parse_battery(const ConfigNode& node) {
  BatteryParams battery;
  battery.full_v = positive(node, "full_v");
  battery.empty_v = node.require_in("empty_v", 0.0, battery.full_v);
  battery.capacity_ah = positive(node, "capacity_ah");
  battery.resistance_ohm = non_negative(node, "resistance_ohm");
  battery.efficiency = node.require_in("efficiency", 0.01, 1.0);
  return battery;
}

std::uint8_t parse_system_id(const ConfigNode& node) {
  const int id = node.as<int>();
  if (id < 1 || id > 255) node.fail("must lie in [1, 255]");
  return static_cast<std::uint8_t>(id);
}

void check_schema(const ConfigNode& node) {
  const int schema = node.require<int>("schema");
  if (schema != kSchema) {
    node.at("schema").fail("is " + std::to_string(schema) + "; this program reads schema " +
                           std::to_string(kSchema));
  }
}

std::vector<ConfigNode> rotor_items(const ConfigNode& rotors) {
  std::vector<ConfigNode> items = rotors.items();
  if (items.empty() || items.size() > kMaxRotors) {
    rotors.fail("must list 1 to " + std::to_string(kMaxRotors) + " rotors");
  }
  return items;
}

void need_rotor_keys(const ConfigNode& node, const ConfigNode& common, const Description& model,
                     MissingKeys& missing) {
  const std::vector<ConfigNode> items = rotor_items(node.at("rotors"));
  for (const std::string_view key : kRotorKeys) {
    if (common.has(key)) continue;
    for (const ConfigNode& item : items) {
      if (item.has(key)) continue;
      if (node.has("rotor")) {
        missing.add(common, key);
      } else {
        missing.add(node, "rotor." + std::string(key));
      }
      break;
    }
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    missing.need(items[i], "spin");
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
void check_missing(const ConfigNode& node, const ConfigNode& common, const Description& model) {
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
  if (const auto battery = node.find("battery")) {
    for (const char* key : {"full_v", "empty_v", "capacity_ah", "resistance_ohm", "efficiency"}) {
      missing.need(*battery, key);
    }
  }
  missing.check(node);
}

std::vector<Rotor> parse_rotors(const ConfigNode& node, const ConfigNode& common,
                                const Description& model) {
  const std::vector<ConfigNode> items = rotor_items(node);
  std::vector<Rotor> rotors;
  std::vector<const ModelLink*> links;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const int index = static_cast<int>(i);
    rotors.push_back(parse_rotor(items[i], common, index, static_cast<int>(items.size())));
    links.push_back(model.link_of(items[i], index + 1));
    model.place(items[i], links.back(), rotors.back());
  }
  model.check_all_listed(node, links);
  check_wakes(node, rotors);
  check_outputs(node, rotors);
  return rotors;
}

}  // namespace

Vehicle Vehicle::load(const std::filesystem::path& file) {
  const ConfigNode node = ConfigNode::load(file);
  check_schema(node);
  Vehicle vehicle;
  const auto urdf = node.find("urdf");
  const auto sdf = node.find("sdf");
  if (urdf && sdf) sdf->fail("is a second model beside 'urdf'; leave one out");
  if (urdf || sdf) vehicle.urdf = node.resolve((urdf ? *urdf : *sdf).as<std::string>());
  const Description model(node, urdf || sdf ? read_model_body(vehicle.urdf) : std::nullopt);
  const ConfigNode common = node.find("rotor").value_or(ConfigNode::empty(file.string()));
  check_missing(node, common, model);

  vehicle.name = node.require<std::string>("name");
  vehicle.mass_kg = model.mass_kg();
  vehicle.inertia_kg_m2 = model.inertia_kg_m2();
  vehicle.rotors = parse_rotors(node.at("rotors"), common, model);
  check_mixer(node.at("rotors"), vehicle);
  if (const auto scales = node.find("scales")) {
    vehicle.scales = parse_scales(*scales);
  } else {
    vehicle.scales = vehicle.control_scales();
  }
  vehicle.body_drag_linear_n_s_m = non_negative(node, "body_drag_linear_n_s_m");
  if (const auto battery = node.find("battery")) vehicle.battery = parse_battery(*battery);
  vehicle.system_id = parse_system_id(node.at("system_id"));
  if (const auto sensors = node.find("sensors")) {
    vehicle.sensors = sensor_set(*sensors);
  }
  node.reject_unused();
  return vehicle;
}

}  // namespace cas::base
