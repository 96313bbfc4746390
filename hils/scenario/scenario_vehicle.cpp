// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/scenario_vehicle.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "base/config/install_paths.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"

namespace cas::hils {

namespace {

/// Each takes two of casd's links and an emulator of its own.
constexpr std::size_t kMostVehicles = 16;
constexpr std::size_t kLongestName = 24;  ///< it is a part of paths of sockets, which are short
constexpr double kFarthest_m = 10'000;

std::string parse_name(const base::ConfigNode& node, const std::vector<ScenarioVehicle>& before) {
  const base::ConfigNode key = node.at("name");
  const auto name = key.as<std::string>();
  const bool plain =
      std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
  if (name.empty() || name.size() > kLongestName || !plain) {
    key.fail("a vehicle's name is made of up to 24 letters, digits and underscores");
  }
  if (std::ranges::count(before, name, &ScenarioVehicle::name) > 0) {
    key.fail("two vehicles have the name '" + name + "'");
  }
  return name;
}

VehiclePose parse_pose(const base::ConfigNode& node) {
  return {.x_m = node.require_in("x_m", -kFarthest_m, kFarthest_m),
          .y_m = node.require_in("y_m", -kFarthest_m, kFarthest_m),
          .yaw_deg = node.get_in("yaw_deg", VehiclePose{}.yaw_deg, -360, 360)};
}

void check_apart(const base::ConfigNode& node, const std::vector<ScenarioVehicle>& vehicles) {
  constexpr double kLeast_m = 1;  // two quadrotors that touch each other fly nowhere
  const ScenarioVehicle& last = vehicles.back();
  for (std::size_t i = 0; i + 1 < vehicles.size(); ++i) {
    const VehiclePose& other = vehicles[i].pose;
    if (std::hypot(last.pose.x_m - other.x_m, last.pose.y_m - other.y_m) >= kLeast_m) continue;
    node.at("pose").fail("stands less than 1 m from '" + vehicles[i].name + "'");
  }
}

ScenarioVehicle parse_alone(const base::ConfigNode& root) {
  ScenarioVehicle vehicle;
  vehicle.vehicle = base::find_config(root.at("vehicle"));
  vehicle.system_id = base::Vehicle::load(vehicle.vehicle).system_id;
  return vehicle;
}

ScenarioVehicle parse_one(const base::ConfigNode& node,
                          const std::vector<ScenarioVehicle>& before) {
  ScenarioVehicle vehicle;
  vehicle.name = parse_name(node, before);
  vehicle.vehicle = base::find_config(node.at("vehicle"));
  vehicle.system_id = static_cast<std::uint8_t>(before.size() + 1);
  vehicle.pose = parse_pose(node.at("pose"));
  vehicle.controller = handed_on(node, "controller");
  if (node.has("sensors")) vehicle.sensors = parse_sensors(node);
  return vehicle;
}

}  // namespace

double ScenarioVehicle::start_yaw_rad() const {
  constexpr double kNorthDeg = 90;
  return std::remainder((kNorthDeg - pose.yaw_deg) * M_PI / 180.0, 2 * M_PI);
}

base::ConfigNode handed_on(const base::ConfigNode& node, std::string_view key) {
  const std::optional<base::ConfigNode> block = node.find(key);
  if (!block) return base::ConfigNode::empty(std::string(key));
  block->mark_used();
  return *block;
}

base::ConfigNode parse_sensors(const base::ConfigNode& node) {
  const base::ConfigNode sensors = handed_on(node, "sensors");
  if (node.has("sensors")) base::sensor_set(sensors);  // for its errors, here
  return sensors;
}

std::vector<ScenarioVehicle> parse_vehicles(const base::ConfigNode& root) {
  const std::optional<base::ConfigNode> list = root.find("vehicles");
  if (!list) return {parse_alone(root)};
  if (root.has("vehicle")) list->fail("a scenario has 'vehicle' or 'vehicles', not both");
  std::vector<ScenarioVehicle> vehicles;
  for (const base::ConfigNode& node : list->items()) {
    vehicles.push_back(parse_one(node, vehicles));
    check_apart(node, vehicles);
  }
  if (vehicles.size() < 2) list->fail("is a list of two or more; for one there is 'vehicle: FILE'");
  if (vehicles.size() > kMostVehicles) list->fail("a run has at most 16 vehicles");
  return vehicles;
}

void parse_vehicle_limits(const base::ConfigNode& root, const std::vector<FlightStep>& steps,
                          std::vector<ScenarioVehicle>& vehicles) {
  const std::optional<base::ConfigNode> list = root.find("vehicles");
  if (!list) return;
  const std::optional<base::ConfigNode> all = root.find("limits");
  const std::vector<base::ConfigNode> nodes = list->items();
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    base::ConfigNode limits = all ? *all : base::ConfigNode::empty("limits");
    if (const auto own = nodes[i].find("limits")) limits = own->merged_over(limits);
    vehicles[i].limits = limits_for(i, parse_limits(limits, steps), steps);
  }
}

}  // namespace cas::hils
