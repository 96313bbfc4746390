// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/vehicle.hpp"

#include "base/config/sensor_set.hpp"

namespace cas::base {
namespace {

constexpr int kSchema = 1;
constexpr double kHuge = 1e9;  // upper end where only the sign is checked

double non_negative(const ConfigNode& node, std::string_view key) {
  return node.require_in(key, 0.0, kHuge);
}

double positive(const ConfigNode& node, std::string_view key) {
  const double value = node.require<double>(key);
  if (value <= 0.0) node.at(key).fail("must be above zero");
  return value;
}

RotorGeometry parse_rotor_geometry(const ConfigNode& node) {
  RotorGeometry rotor;
  rotor.position_B_m = node.require<Eigen::Vector3d>("position_B_m");
  rotor.spin = node.require<int>("spin");
  if (rotor.spin != 1 && rotor.spin != -1) {
    node.at("spin").fail("must be 1 (counter-clockwise seen from above) or -1 (clockwise)");
  }
  return rotor;
}

std::array<RotorGeometry, kRotors> parse_rotors(const ConfigNode& node) {
  const std::vector<ConfigNode> items = node.items();
  std::array<RotorGeometry, kRotors> rotors;
  if (items.size() != rotors.size()) node.fail("must list 4 rotors");
  for (std::size_t i = 0; i < rotors.size(); ++i) rotors[i] = parse_rotor_geometry(items[i]);
  return rotors;
}

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
  return rotor;
}

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

Eigen::Vector3d parse_inertia(const ConfigNode& node) {
  const Eigen::Vector3d inertia = node.as<Eigen::Vector3d>();
  if ((inertia.array() <= 0.0).any()) node.fail("must be above zero in each axis");
  if (2.0 * inertia.maxCoeff() > inertia.sum()) {
    node.fail("belongs to no rigid body: one moment exceeds the sum of the other two");
  }
  return inertia;
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

}  // namespace

Vehicle Vehicle::load(const std::filesystem::path& file) {
  const ConfigNode node = ConfigNode::load(file);
  check_schema(node);
  Vehicle vehicle;
  vehicle.name = node.require<std::string>("name");
  vehicle.urdf = node.resolve(node.require<std::string>("urdf"));
  vehicle.mass_kg = positive(node, "mass_kg");
  vehicle.inertia_kg_m2 = parse_inertia(node.at("inertia_kg_m2"));
  vehicle.rotors = parse_rotors(node.at("rotors"));
  vehicle.rotor = parse_rotor_params(node.at("rotor"));
  vehicle.scales = parse_scales(node.at("scales"));
  vehicle.body_drag_linear_n_s_m = non_negative(node, "body_drag_linear_n_s_m");
  if (const auto battery = node.find("battery")) vehicle.battery = parse_battery(*battery);
  vehicle.system_id = parse_system_id(node.at("system_id"));
  if (const auto sensors = node.find("sensors")) {
    vehicle.sensors = sensor_set(*sensors);
  }
  node.reject_unused();
  return vehicle;
}

Eigen::Matrix4d Vehicle::mixing_matrix() const {
  const double k_f = rotor.thrust_coefficient;
  const double k_m = rotor.torque_coefficient;
  Eigen::Matrix4d mixer;
  for (int i = 0; i < kRotors; ++i) {
    const RotorGeometry& geometry = rotors[static_cast<std::size_t>(i)];
    // Thrust T along -Dz at (x, y) in D gives the moment (-y T, x T, .); y_D = -y_B. A rotor's
    // reaction torque is against its spin: counter-clockwise from above turns the body about +Dz.
    mixer.col(i) << k_f, geometry.position_B_m.y() * k_f, geometry.position_B_m.x() * k_f,
        geometry.spin * k_m;
  }
  return mixer;
}

}  // namespace cas::base
