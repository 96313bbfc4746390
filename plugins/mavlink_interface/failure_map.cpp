// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/failure_map.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "base/config/sensor_names.hpp"

namespace cas::sim {
namespace {

using mav::services::FailureOrder;
using Unit = mav::services::FailureUnit;
using Type = mav::services::FailureType;

/// How one unit fails in one way. `$rotor` is replaced by a rotor's number.
struct Failure {
  Unit unit;
  Type type;
  std::array<std::string_view, 2> effects;  ///< of plugin `fault`; the second may be empty
};

// Sizes are those of docs/use/campaign.md's catalogue where it has them; garbage is at least ten
// times the sensor's own noise.
constexpr std::array kFailures{
    Failure{Unit::kGyro, Type::kStuck, {"freeze: {sensor: imu, field: angular_rate}"}},
    Failure{Unit::kGyro, Type::kGarbage, {"noise: {sensor: imu, angular_rate_deg_s: 200}"}},
    Failure{Unit::kGyro, Type::kWrong, {"bias: {sensor: imu, angular_rate_deg_s: [10, 0, 0]}"}},
    Failure{Unit::kAccel, Type::kStuck, {"freeze: {sensor: imu, field: specific_force}"}},
    Failure{Unit::kAccel, Type::kGarbage, {"noise: {sensor: imu, specific_force_m_s2: 50}"}},
    Failure{Unit::kAccel, Type::kWrong, {"bias: {sensor: imu, specific_force_m_s2: [2, 0, 0]}"}},

    Failure{Unit::kMag, Type::kOff, {"drop: magnetometer"}},
    Failure{Unit::kMag, Type::kStuck, {"freeze: magnetometer"}},
    Failure{Unit::kMag, Type::kGarbage, {"noise: {sensor: magnetometer, field_gauss: 1}"}},
    Failure{Unit::kMag, Type::kWrong, {"bias: {sensor: magnetometer, field_gauss: [0, 0.3, 0]}"}},
    Failure{Unit::kMag, Type::kSlow, {"drop: {sensor: magnetometer, all_but: 10}"}},
    Failure{Unit::kMag, Type::kDelayed, {"delay: {sensor: magnetometer, by_s: 0.5}"}},
    Failure{Unit::kMag, Type::kIntermittent, {"drop: {sensor: magnetometer, share: 0.5}"}},

    Failure{Unit::kBaro, Type::kOff, {"drop: barometer"}},
    Failure{Unit::kBaro, Type::kStuck, {"freeze: barometer"}},
    Failure{Unit::kBaro, Type::kGarbage, {"noise: {sensor: barometer, pressure_pa: 500}"}},
    Failure{Unit::kBaro, Type::kWrong, {"bias: {sensor: barometer, pressure_pa: -60}"}},
    Failure{Unit::kBaro, Type::kSlow, {"drop: {sensor: barometer, all_but: 10}"}},
    Failure{Unit::kBaro, Type::kDelayed, {"delay: {sensor: barometer, by_s: 0.5}"}},
    Failure{Unit::kBaro, Type::kIntermittent, {"drop: {sensor: barometer, share: 0.5}"}},

    Failure{Unit::kGps, Type::kOff, {"drop: gps"}},
    Failure{Unit::kGps, Type::kStuck, {"freeze: gps"}},
    Failure{Unit::kGps,
            Type::kGarbage,
            {"noise: {sensor: gps, position_m: 1000}", "noise: {sensor: gps, velocity_m_s: 100}"}},
    Failure{Unit::kGps, Type::kWrong, {"bias: {sensor: gps, position_m: [30, 0, 0]}"}},
    Failure{Unit::kGps, Type::kSlow, {"drop: {sensor: gps, all_but: 10}"}},
    Failure{Unit::kGps, Type::kDelayed, {"delay: {sensor: gps, by_s: 0.8}"}},
    Failure{Unit::kGps, Type::kIntermittent, {"drop: {sensor: gps, share: 0.5}"}},

    Failure{Unit::kVio, Type::kOff, {"drop: odometry"}},
    Failure{Unit::kVio, Type::kStuck, {"freeze: odometry"}},
    Failure{Unit::kVio,
            Type::kGarbage,
            {"noise: {sensor: odometry, position_m: 50}",
             "noise: {sensor: odometry, velocity_m_s: 20}"}},
    Failure{Unit::kVio, Type::kWrong, {"bias: {sensor: odometry, position_m: [2, 0, 0]}"}},
    Failure{Unit::kVio, Type::kSlow, {"drop: {sensor: odometry, all_but: 10}"}},
    Failure{Unit::kVio, Type::kDelayed, {"delay: {sensor: odometry, by_s: 0.3}"}},
    Failure{Unit::kVio, Type::kIntermittent, {"drop: {sensor: odometry, share: 0.5}"}},

    Failure{Unit::kDistanceSensor, Type::kOff, {"drop: rangefinder"}},
    Failure{Unit::kDistanceSensor, Type::kStuck, {"freeze: rangefinder"}},
    Failure{Unit::kDistanceSensor, Type::kGarbage, {"noise: {sensor: rangefinder, distance_m: 5}"}},
    Failure{Unit::kDistanceSensor, Type::kWrong, {"bias: {sensor: rangefinder, distance_m: 1}"}},
    Failure{Unit::kDistanceSensor, Type::kSlow, {"drop: {sensor: rangefinder, all_but: 10}"}},
    Failure{Unit::kDistanceSensor, Type::kDelayed, {"delay: {sensor: rangefinder, by_s: 0.5}"}},
    Failure{
        Unit::kDistanceSensor, Type::kIntermittent, {"drop: {sensor: rangefinder, share: 0.5}"}},

    Failure{Unit::kAirspeed, Type::kOff, {"drop: airspeed"}},
    Failure{Unit::kAirspeed, Type::kStuck, {"freeze: airspeed"}},
    Failure{Unit::kAirspeed,
            Type::kGarbage,
            {"noise: {sensor: airspeed, differential_pressure_pa: 500}"}},
    Failure{
        Unit::kAirspeed, Type::kWrong, {"scale: {sensor: airspeed, differential_pressure: 0.5}"}},
    Failure{Unit::kAirspeed, Type::kSlow, {"drop: {sensor: airspeed, all_but: 10}"}},
    Failure{Unit::kAirspeed, Type::kDelayed, {"delay: {sensor: airspeed, by_s: 0.5}"}},
    Failure{Unit::kAirspeed, Type::kIntermittent, {"drop: {sensor: airspeed, share: 0.5}"}},

    Failure{Unit::kBattery, Type::kOff, {"voltage_share: 0"}},

    Failure{Unit::kMotor, Type::kOff, {"rotor: {number: $rotor, stop: true}"}},
    Failure{Unit::kMotor, Type::kStuck, {"rotor: {number: $rotor, stuck: true}"}},
    Failure{Unit::kMotor, Type::kWrong, {"rotor: {number: $rotor, thrust_share: -0.5}"}},
};

constexpr std::string_view kRotor = "$rotor";

/// A kind of sensor, and the word that names it in an effect.
struct SensorOfUnit {
  VehiclePart part;
  std::string_view word;
};

/// The sensor that a unit is; nullopt: it is none.
std::optional<SensorOfUnit> sensor_of(Unit unit) {
  switch (unit) {
    case Unit::kGyro:
    case Unit::kAccel:
      return SensorOfUnit{kPartImu, "imu"};
    case Unit::kMag:
      return SensorOfUnit{kPartMagnetometer, "magnetometer"};
    case Unit::kBaro:
      return SensorOfUnit{kPartBarometer, "barometer"};
    case Unit::kGps:
      return SensorOfUnit{kPartGps, "gps"};
    case Unit::kDistanceSensor:
      return SensorOfUnit{kPartRangefinder, "rangefinder"};
    case Unit::kAirspeed:
      return SensorOfUnit{kPartAirspeed, "airspeed"};
    case Unit::kVio:
      return SensorOfUnit{kPartOdometry, "odometry"};
    default:
      return std::nullopt;
  }
}

/// Instances that an order means, from 1. Empty: the vehicle has none such.
std::vector<int> instances(const FailureOrder& failure, const VehicleParts& parts) {
  const auto sensor = sensor_of(failure.unit);
  int most = sensor ? parts.sensors.most(sensor->part) : 1;
  if (failure.unit == Unit::kMotor) most = parts.rotors;
  if (failure.instance > most) return {};
  if (failure.instance > 0) return {failure.instance};
  std::vector<int> all;
  for (int i = 1; i <= most; ++i) all.push_back(i);
  return all;
}

/// An effect on the sensor of that number, as text for plugin `fault`.
std::string with_sensor(std::string_view effect, Unit unit, int number) {
  std::string text(effect);
  const auto sensor = sensor_of(unit);
  if (!sensor || number == 1) return text;
  text.replace(text.find(sensor->word), sensor->word.size(),
               base::sensor_name(sensor->word, number));
  return text;
}

std::string with_rotor(std::string_view effect, int rotor) {
  std::string text(effect);
  const std::size_t at = text.find(kRotor);
  if (at != std::string::npos) text.replace(at, kRotor.size(), std::to_string(rotor));
  return text;
}

}  // namespace

std::optional<std::vector<std::string>> fault_orders(const FailureOrder& failure,
                                                     const VehicleParts& parts) {
  const bool ends = failure.type == Type::kOk;
  const auto known = std::ranges::find_if(kFailures, [&](const Failure& each) {
    return each.unit == failure.unit && (ends || each.type == failure.type);
  });
  const std::vector<int> meant = instances(failure, parts);
  if (known == kFailures.end() || meant.empty()) return std::nullopt;
  std::vector<std::string> orders;
  for (const int instance : meant) {
    const bool numbered = failure.unit == Unit::kMotor || instance > 1;
    const std::string number = numbered ? " " + std::to_string(instance) : "";
    const std::string name = "'injected " + to_words(failure.unit) + number + "'";
    orders.push_back("{end: " + name + "}");
    if (ends) continue;
    for (const std::string_view effect : known->effects) {
      if (effect.empty()) continue;
      const std::string own = failure.unit == Unit::kMotor
                                  ? with_rotor(effect, instance)
                                  : with_sensor(effect, failure.unit, instance);
      orders.push_back("{name: " + name + ", at_s: 0, " + own + "}");
    }
  }
  return orders;
}

mav::services::FailureRefusal why_no_orders(const FailureOrder& failure,
                                            const VehicleParts& parts) {
  using mav::services::FailureRefusal;
  const auto fails = [&](Type type) {
    return std::ranges::any_of(kFailures, [&](const Failure& each) {
      return each.unit == failure.unit && (type == Type::kOk || each.type == type);
    });
  };
  if (!fails(Type::kOk)) return FailureRefusal::kUnit;
  if (!fails(failure.type)) return FailureRefusal::kType;
  FailureOrder all = failure;
  all.instance = 0;
  return instances(all, parts).empty() ? FailureRefusal::kPart : FailureRefusal::kInstance;
}

}  // namespace cas::sim
