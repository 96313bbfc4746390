// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"
#include "base/earth/geodesy.hpp"
#include "base/time/clock.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/scenario/scenario_limits.hpp"
#include "hils/scenario/scenario_vehicle.hpp"
#include "hils/scenario/wake_up.hpp"

namespace cas::hils {

/// How simulator and controller are connected.
enum class Architecture {
  kDirect,  ///< one process on the virtual clock
  kSitl,    ///< casd between two UDP links, no serial line
  kTs,      ///< casd with `threads: blocking`: our reading of the traditional set-up of [HILS]
  kLoop,    ///< casd with `threads: single`: one event loop
  kTcas,    ///< casd with `threads: per_link`
};
inline constexpr std::array kArchitectures{Architecture::kDirect, Architecture::kSitl,
                                           Architecture::kTs, Architecture::kLoop,
                                           Architecture::kTcas};

std::string_view to_string(Architecture architecture);
/// @throws base::ConfigError for another word
Architecture parse_architecture(std::string_view word);

/// Nominal rates of the HIL stream, Hz.
struct Rates {
  double sensor_hz = 500;
  double gps_hz = 5;
  double controls_hz = 400;
};

/// One experiment as config/scenarios/*.yaml describes it. Keys are the members' names.
struct Scenario {
  std::string name;
  std::string description;
  std::filesystem::path file;
  std::vector<ScenarioVehicle> vehicles;  ///< key `vehicle` stands for a list of one
  base::Geodetic home;
  double decimal_year = 2026.5;
  std::uint64_t seed = 1;
  Architecture architecture = Architecture::kTcas;
  int step_us = 1000;
  std::string integrator = "rk4";
  Rates rates;
  base::ConfigNode line = base::ConfigNode::empty();        ///< as fcu_emulator's `line`
  base::ConfigNode controller = base::ConfigNode::empty();  ///< stamp, actuators, params
  base::ConfigNode sensors = base::ConfigNode::empty();     ///< a set, or keys that differ
  std::vector<base::ConfigNode> plugins;                    ///< further plugins of each vehicle
  WakeUpFigures wake_up;        ///< threads of casd on the virtual clock
  double drain_tick_ms = 1;     ///< as casd's key, for architecture ts
  bool ground_station = false;  ///< one that listens and loads the parameter list now and then
  std::vector<FlightStep> steps;
  ScenarioFaults faults;
  Limits limits;  ///< of every vehicle that has none of its own

  bool flies_several() const { return vehicles.size() > 1; }
  VehicleNames names() const;
  std::vector<std::uint8_t> systems() const;
  const base::ConfigNode& sensors_of(std::size_t vehicle) const;
  const Limits& limits_of(std::size_t vehicle) const;

  /// Reads and checks a scenario file. @throws base::ConfigError with file, line and key path
  static Scenario load(const std::filesystem::path& file);
};

}  // namespace cas::hils
