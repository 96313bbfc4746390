// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/config_whole.hpp"

/// Names of the sensors of a vehicle that has several of a kind: the first has the name of its
/// plugin, the others its number behind: imu, imu_2, imu_3. Topics, blocks of sensor sets, faults
/// and result files have these names.
namespace cas::base {

/// A kind of sensor of which a vehicle may have several.
struct SensorKind {
  std::string_view plugin;
  int most = 1;
};

inline constexpr std::array<SensorKind, 5> kSensorKinds{
    {{"imu", 3}, {"gps", 2}, {"magnetometer", 3}, {"barometer", 2}, {"rangefinder", 2}}};

/// A sensor of a vehicle: its plugin, and its number from 1.
struct SensorName {
  std::string_view plugin;
  int number = 1;
};

/// How many sensors of a plugin a vehicle may have; 1 for every other plugin.
constexpr int most_sensors(std::string_view plugin) {
  for (const SensorKind& kind : kSensorKinds) {
    if (kind.plugin == plugin) return kind.most;
  }
  return 1;
}

/// "imu", "imu_2". @param number  from 1
inline std::string sensor_name(std::string_view plugin, int number) {
  std::string name(plugin);
  return number == 1 ? name : name + "_" + std::to_string(number);
}

/// The sensor that a word names, of those that may be several; nullopt for another word.
constexpr std::optional<SensorName> parse_sensor_name(std::string_view word) {
  for (const SensorKind& kind : kSensorKinds) {
    if (word == kind.plugin) return SensorName{kind.plugin, 1};
    const bool fits = word.size() == kind.plugin.size() + 2 && word.starts_with(kind.plugin) &&
                      word[kind.plugin.size()] == '_';
    if (!fits) continue;
    const int number = word.back() - '0';
    if (number >= 2 && number <= kind.most) return SensorName{kind.plugin, number};
  }
  return std::nullopt;
}

/// Key `number` of a plugin in a vehicle's list: 1 without the key.
/// @throws ConfigError for a number beyond most_sensors(), and for a plugin that is no such sensor
inline int sensor_number(const ConfigNode& params, std::string_view plugin) {
  const auto key = params.find("number");
  if (!key) return 1;
  const int most = most_sensors(plugin);
  if (most == 1) {
    key->fail("a vehicle has one plugin '" + std::string(plugin) +
              "'; several can be imu, gps, magnetometer, barometer and rangefinder");
  }
  return static_cast<int>(whole_in(*key, 1, most));
}

/// Block of a sensor in a sensor set: its own keys over those of the first of its kind.
/// @return nullopt if the set has neither
inline std::optional<ConfigNode> sensor_block(const ConfigNode& set, std::string_view name) {
  const auto own = set.find(name);
  const auto sensor = parse_sensor_name(name);
  if (!sensor || sensor->number == 1) return own;
  const auto first = set.find(sensor->plugin);
  if (!own || !first) return own ? own : first;
  return own->merged_over(*first);
}

/// Names of the blocks of a set that are a second or third sensor, in the order of kSensorKinds.
inline std::vector<std::string> further_sensors(const ConfigNode& set) {
  std::vector<std::string> names;
  if (!set.is_map()) return names;
  for (const SensorKind& kind : kSensorKinds) {
    for (int number = 2; number <= kind.most; ++number) {
      const std::string name = sensor_name(kind.plugin, number);
      if (set.has(name)) names.push_back(name);
    }
  }
  return names;
}

}  // namespace cas::base
