// SPDX-License-Identifier: BSD-3-Clause
// The blocks `propeller`, `electric` and `battery` of a vehicle file.
#include "base/config/propulsion_file.hpp"

#include <fmt/format.h>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "base/config/model_match.hpp"

namespace cas::base {
namespace {

constexpr double kLargest = 1e9;  // where only the sign is checked
constexpr std::array<std::string_view, 4> kOfPropeller{"thrust_coefficient", "torque_coefficient",
                                                       "zero_thrust_speed_m_s", "radius_m"};
constexpr std::array<std::string_view, 3> kOfElectric{"omega_max_rad_s", "time_constant_up_s",
                                                      "time_constant_down_s"};
constexpr std::size_t kMostRows = 500;

bool is_one_of(std::span<const std::string_view> keys, std::string_view key) {
  return std::ranges::find(keys, key) != keys.end();
}

/// Refuses keys that stand beside the block which replaces them, or at a rotor whose common block
/// does.
void refuse_replaced(const ConfigNode& item, const ConfigNode& common, const char* block,
                     std::span<const std::string_view> keys) {
  const bool own = item.has(block);
  for (const std::string_view key : keys) {
    const auto beside = item.find(key);
    if (beside) beside->fail(std::string("is given by the block `") + block + "`; leave one out");
    const auto in_common = common.find(key);
    if (!own && in_common) {
      in_common->fail(std::string("is given by the block `") + block + "`; leave one out");
    }
  }
}

// The propeller's curves.

struct Rows {
  std::vector<double> ratio, thrust, power;
};

/// Adds a row. @return what is wrong with it, or nothing
std::string add_row(Rows& rows, double ratio, double thrust, double power) {
  constexpr double kMost = 10;
  if (!(std::abs(ratio) <= kMost && std::abs(thrust) <= kMost && std::abs(power) <= kMost)) {
    return "has no advance ratio and coefficients, which lie within 10 of 0";
  }
  if (!rows.ratio.empty() && ratio <= rows.ratio.back()) {
    return "must have a larger advance ratio than the row before";
  }
  if (rows.ratio.size() == kMostRows) {
    return fmt::format("is one too many: a table has at most {} rows", kMostRows);
  }
  rows.ratio.push_back(ratio);
  rows.thrust.push_back(thrust);
  rows.power.push_back(power);
  return "";
}

Rows rows_of_list(const ConfigNode& node) {
  Rows rows;
  for (const ConfigNode& item : node.items()) {
    const auto row = item.as<Eigen::Vector3d>();
    const std::string wrong = add_row(rows, row[0], row[1], row[2]);
    if (!wrong.empty()) item.fail(wrong);
  }
  if (rows.ratio.empty()) node.fail("has no row [J, CT, CP]");
  return rows;
}

/// A file in the columns of UIUC's propeller data: J, CT, CP and more, which is not read; lines
/// before the first number are its head.
Rows rows_of_file(const ConfigNode& node) {
  const std::filesystem::path path = node.resolve(node.as<std::string>());
  std::ifstream file(path);
  if (!file) node.fail("names " + path.string() + ", which cannot be read");
  Rows rows;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    double ratio = 0;
    double thrust = 0;
    double power = 0;
    const bool blank = line.find_first_not_of(" \t\r") == std::string::npos;
    if (blank || (!(words >> ratio) && rows.ratio.empty())) continue;
    const std::string place = fmt::format("{}:{}: ", path.string(), number);
    if (!words || !(words >> thrust >> power)) {
      throw ConfigError(place + "must have three numbers, J, CT and CP");
    }
    const std::string wrong = add_row(rows, ratio, thrust, power);
    if (!wrong.empty()) throw ConfigError(place + wrong);
  }
  if (rows.ratio.empty()) node.fail("names " + path.string() + ", which has no row J CT CP");
  return rows;
}

PropellerCurve polynomial_of(const ConfigNode& node, double scale) {
  auto c = node.as<std::vector<double>>();
  if (c.empty() || c.size() > 3) {
    node.fail("must have one to three coefficients, of 1, J and J^2; a curve of more is a `table`");
  }
  c.resize(3);
  return PropellerCurve::polynomial(scale * c[0], scale * c[1], scale * c[2]);
}

void check_curve(const ConfigNode& node, const char* name, const PropellerCurve& curve) {
  if (!(curve.at_rest() > 0)) {
    node.fail(fmt::format("has a {} of {:f} in still air (J = 0); it must be above 0", name,
                          curve.at_rest()));
  }
  if (!curve.falls()) {
    node.fail(std::string("has a ") + name +
              " that rises at the end; it goes on like that, and no propeller does");
  }
}

Propeller parse_propeller(const ConfigNode& node) {
  Propeller propeller;
  propeller.diameter_m = positive_value(node, "diameter_m");
  const auto table = node.find("table");
  const auto file = node.find("file");
  const auto thrust = node.find("CT");
  if (int(table.has_value()) + int(file.has_value()) + int(thrust.has_value()) != 1) {
    node.fail("must have one of `table`, `file`, and `CT` with `CQ` or `CP`");
  }
  if (thrust) {
    const auto torque = node.find("CQ");
    const auto power = node.find("CP");
    if (torque.has_value() == power.has_value()) {
      node.fail("must have one of `CQ` and `CP` beside `CT`");
    }
    propeller.thrust = polynomial_of(*thrust, 1);
    propeller.torque = torque ? polynomial_of(*torque, 1) : polynomial_of(*power, 1 / (2 * M_PI));
    check_curve(*thrust, "CT", propeller.thrust);
    check_curve(torque ? *torque : *power, torque ? "CQ" : "CP", propeller.torque);
    return propeller;
  }
  const ConfigNode& source = table ? *table : *file;
  Rows rows = table ? rows_of_list(source) : rows_of_file(source);
  for (double& power : rows.power) power /= 2 * M_PI;
  propeller.thrust = PropellerCurve::table(rows.ratio, rows.thrust);
  propeller.torque = PropellerCurve::table(rows.ratio, rows.power);
  check_curve(source, "CT", propeller.thrust);
  check_curve(source, "CP", propeller.torque);
  return propeller;
}

// The battery.

constexpr std::size_t kMostPoints = 50;

std::vector<BatteryParams::Point> parse_cell(const ConfigNode& node, double cells) {
  std::vector<BatteryParams::Point> curve;
  for (const ConfigNode& item : node.items()) {
    const auto pair = item.as<std::vector<double>>();
    if (pair.size() != 2) item.fail("must be a pair [charge, voltage]");
    if (!curve.empty() &&
        !(pair[0] > curve.back().charge && cells * pair[1] >= curve.back().voltage_v)) {
      item.fail("must have a larger charge than the pair before, and no lower voltage");
    }
    if (!(pair[1] > 0 && pair[1] < 10)) item.fail("must have the voltage of one cell");
    curve.push_back({pair[0], cells * pair[1]});
  }
  if (curve.size() < 2 || curve.size() > kMostPoints || curve.front().charge != 0 ||
      curve.back().charge != 1) {
    node.fail(
        fmt::format("must have 2 to {} pairs [charge, voltage], from charge 0 to 1", kMostPoints));
  }
  return curve;
}

void parse_rc_pairs(const ConfigNode& node, BatteryParams& battery) {
  const std::vector<ConfigNode> items = node.items();
  if (items.size() > battery.rc_pairs.size()) node.fail("has more than two pairs");
  for (std::size_t i = 0; i < items.size(); ++i) {
    battery.rc_pairs[i] = {positive_value(items[i], "resistance_ohm"),
                           items[i].require_in("time_constant_s", 0.01, kLargest)};
  }
}

}  // namespace

std::optional<ConfigNode> rotor_block(const ConfigNode& item, const ConfigNode& common,
                                      std::string_view key) {
  const auto own = item.find(key);
  return own ? own : common.find(key);
}

bool is_replaced(const ConfigNode& item, const ConfigNode& common, std::string_view key) {
  return (is_one_of(kOfPropeller, key) && rotor_block(item, common, "propeller")) ||
         (is_one_of(kOfElectric, key) && rotor_block(item, common, "electric"));
}

void need_propulsion_keys(const ConfigNode& rotor, MissingKeys& missing) {
  if (const auto propeller = rotor.find("propeller")) missing.need(*propeller, "diameter_m");
  if (const auto electric = rotor.find("electric")) {
    for (const char* key : {"kv_rpm_v", "resistance_ohm", "no_load_current_a", "max_current_a"}) {
      missing.need(*electric, key);
    }
  }
}

void need_battery_keys(const ConfigNode& battery, bool electric, MissingKeys& missing) {
  const bool cells = battery.has("cells") || battery.has("cell_v");
  for (const char* key : {cells ? "cells" : "full_v", cells ? "cell_v" : "empty_v", "capacity_ah",
                          "resistance_ohm"}) {
    missing.need(battery, key);
  }
  if (!electric) missing.need(battery, "efficiency");
}

void read_propeller(const ConfigNode& item, const ConfigNode& common, Rotor& rotor) {
  const auto node = rotor_block(item, common, "propeller");
  if (!node) return;
  refuse_replaced(item, common, "propeller", kOfPropeller);
  RotorParams& params = rotor.params;
  if (params.inflow_thrust_slope > 0) {
    node->fail("follows the axial airspeed, and so does inflow_thrust_slope; leave one out");
  }
  if (!(params.reference_density_kg_m3 > 0)) {
    node->fail("needs reference_density_kg_m3 above 0: the air for which hover is reckoned");
  }
  rotor.propeller = parse_propeller(*node);
  constexpr double kOne_rad_s = 1;
  params.thrust_coefficient =
      rotor.propeller->thrust_n(params.reference_density_kg_m3, kOne_rad_s, 0);
  params.torque_coefficient =
      rotor.propeller->torque_nm(params.reference_density_kg_m3, kOne_rad_s, 0);
  params.radius_m = rotor.propeller->diameter_m / 2;
}

void read_electric(const ConfigNode& item, const ConfigNode& common,
                   const std::optional<BatteryParams>& battery, Rotor& rotor) {
  const auto node = rotor_block(item, common, "electric");
  if (!node) return;
  refuse_replaced(item, common, "electric", kOfElectric);
  if (!battery) node->fail("needs a `battery` in the vehicle file, which feeds the motors");
  ElectricMotor motor;
  motor.torque_constant_nm_a = 60 / (2 * M_PI * positive_value(*node, "kv_rpm_v"));
  motor.resistance_ohm = positive_value(*node, "resistance_ohm");
  motor.no_load_current_a = node->require_in("no_load_current_a", 0, kLargest);
  motor.max_current_a = positive_value(*node, "max_current_a");
  motor.supply_v = battery->full_v;
  if (const auto steps = node->find("esc_steps")) {
    motor.esc_steps = steps->as<int>();
    if (motor.esc_steps < 2 || motor.esc_steps > 1000000) steps->fail("must lie in [2, 1000000]");
  }
  if (motor.max_current_a <= motor.no_load_current_a) {
    node->at("max_current_a").fail("must be above no_load_current_a, or the motor stands");
  }
  // RK4 in steps of 1 ms is stable to 2785 1/s; the load and the battery want their share.
  constexpr double kShortest_s = 2e-3;
  RotorParams& params = rotor.params;
  const double fastest_s = motor.lag_s(params.inertia_kg_m2, 0, 0);
  if (fastest_s < kShortest_s) {
    node->fail(
        fmt::format("makes a time constant J R / K^2 of {:f} ms with inertia_kg_m2; below 2 "
                    "ms it cannot be integrated in steps of 1 ms",
                    1e3 * fastest_s));
  }
  params.omega_max_rad_s = motor.steady_speed_rad_s(1, params.torque_coefficient);
  if (params.omega_idle_rad_s >= params.omega_max_rad_s) {
    node->fail(
        fmt::format("turns the rotor at {:f} rad/s at most, which is not above "
                    "omega_idle_rad_s",
                    params.omega_max_rad_s));
  }
  rotor.electric = motor;
}

BatteryParams read_battery(const ConfigNode& node, bool electric) {
  BatteryParams battery;
  if (const auto cells = node.find("cells")) {
    const int count = cells->as<int>();
    if (count < 1 || count > 1000) cells->fail("must lie in [1, 1000]");
    for (const char* key : {"full_v", "empty_v"}) {
      if (const auto straight = node.find(key)) straight->fail("is given by cell_v; leave one out");
    }
    battery.curve = parse_cell(node.at("cell_v"), count);
    battery.full_v = battery.curve.back().voltage_v;
    battery.empty_v = battery.curve.front().voltage_v;
  } else {
    battery.full_v = positive_value(node, "full_v");
    battery.empty_v = node.require_in("empty_v", 0.0, battery.full_v);
  }
  battery.capacity_ah = positive_value(node, "capacity_ah");
  battery.resistance_ohm = node.require_in("resistance_ohm", 0.0, kLargest);
  if (const auto pairs = node.find("rc_pairs")) parse_rc_pairs(*pairs, battery);
  if (!electric) {
    battery.efficiency = node.require_in("efficiency", 0.01, 1.0);
  } else if (const auto efficiency = node.find("efficiency")) {
    efficiency->fail("is for rotors without `electric`: a circuit has its own losses");
  }
  return battery;
}

}  // namespace cas::base
