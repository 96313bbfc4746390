// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"
#include "base/earth/geodesy.hpp"
#include "base/earth/magnetic_field.hpp"
#include "base/earth/weather.hpp"
#include "base/enum_words.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/flight/incident_kind.hpp"
#include "hils/scenario/firmware.hpp"

namespace cas::hils {

/// Bounds of figures by their keys: of figure_table() or response_table().
using FigureLimits = std::map<std::string, double>;

/// Limits of a run's figures; one that a scenario leaves out is not judged.
struct Limits {
  std::optional<std::uint64_t> lost;              ///< packets of each HIL message in the window
  std::optional<double> rate_error_pct;           ///< received rate against nominal, either way
  std::optional<double> delivered_pct;            ///< least share of each HIL message that arrives
  FigureLimits figures;                           ///< of the vehicle
  std::map<std::string, FigureLimits> responses;  ///< by the name of the step
  std::map<std::string, double> rates_hz;  ///< least of stock firmware's messages in the hold
  std::set<IncidentKind> allow;            ///< of the scenario: these fail no run
};

/// Where a run is flown: keys `world`, `model_path`, `missing` and `collada_up_axis` of a
/// simulation file.
/// Elevation files and folders of them, as a simulation's `terrain`.
struct ScenarioTerrain {
  std::vector<std::filesystem::path> files;
  std::filesystem::path geoid;  ///< empty: elevations are above mean sea level
};

struct ScenarioWorld {
  std::filesystem::path sdf;  ///< empty: flat ground at the height of home, or the terrain
  std::optional<ScenarioTerrain> terrain{};
  std::vector<std::filesystem::path> model_path;
  bool ignore_missing = false;
  bool applies_up_axis = false;
};

/// Start pose of a vehicle, as in a world: x east and y north of home, z of its lowest point.
struct VehiclePose {
  double x_m = 0;
  double y_m = 0;
  std::optional<double> z_m{};  ///< nullopt: on the uppermost surface
  double yaw_deg = 90;          ///< of the nose, counter-clockwise from east: north
};

/// One vehicle of a scenario. Keys are the members' names.
struct ScenarioVehicle {
  std::string name{kVehicleName};  ///< for reports, and the folder of its topics
  std::filesystem::path vehicle;
  std::uint8_t system_id = 1;  ///< of several: 1, 2, ... in the order of the list
  VehiclePose pose;
  base::ConfigNode controller = base::ConfigNode::empty();  ///< keys before the scenario's
  std::optional<base::ConfigNode> sensors;                  ///< instead of the scenario's
  std::optional<Limits> limits;                             ///< instead of the scenario's

  /// Heading of the nose in N.
  double start_yaw_rad() const;
};

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

/// The words in files and flags.
inline constexpr base::EnumWords<Architecture::kTcas> kArchitectureWords{"direct", "sitl", "ts",
                                                                         "loop", "tcas"};
constexpr std::string_view to_string(Architecture architecture) {
  return kArchitectureWords[architecture];
}
/// For people: "TCAS".
std::string title_of(Architecture architecture);
/// @throws base::ConfigError for another word
Architecture parse_architecture(std::string_view word);

/// Nominal rates of the HIL stream, Hz.
struct Rates {
  double sensor_hz = 500;
  double gps_hz = 5;
  double controls_hz = 400;
};

/// Whether the flight has sticks that may be lost: of its ground station, or of a step.
bool has_sticks(const Scenario& scenario);
/// Refuses `silence: sticks` without sticks, and `silence: ground` of stock firmware.
/// @throws base::ConfigError
void check_silences(const base::ConfigNode& faults, const Scenario& scenario);

/// The plugins of one vehicle that faults may need, by name.
std::set<std::string> plugins_of(const Scenario& scenario, std::size_t vehicle);
/// Plugin fault changes the samples of other plugins, and asks plugin wind for a gust: a fault
/// whose plugin the vehicle does not have would begin and do nothing.
/// @param plugins  all of the vehicle, by name. @throws base::ConfigError for such a fault
void check_fault_plugins(const std::set<std::string>& plugins,
                         const std::vector<VehicleFault>& faults);
/// The names of a list of plugins.
std::set<std::string> plugin_names(const std::vector<base::ConfigNode>& plugins);

/// One experiment as config/scenarios/*.yaml describes it. Keys are the members' names.
///
///   Scenario::load(file) -> simulation file and controllers' files -> programs run -> steps are
///   flown -> checks against `limits`
struct Scenario {
  std::string name;
  std::string description;
  std::filesystem::path file;
  std::vector<ScenarioVehicle> vehicles;  ///< key `vehicle` is a list of one
  ScenarioWorld world;
  std::optional<base::Geodetic> home;  ///< nullopt: that of the world
  double decimal_year = base::kUsualYear;
  base::Weather weather;
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
  Limits limits;                     ///< of every vehicle that has none of its own
  std::optional<Firmware> firmware;  ///< which flies; nullopt: our controller, or a real one
  std::optional<Geofence> fence;     ///< of stock autopilots, for this flight

  bool flies_several() const { return vehicles.size() > 1; }
  /// Suffix of the names of a vehicle's files and program: "_left"; empty for a single vehicle.
  std::string suffix_of(std::size_t vehicle) const {
    return flies_several() ? "_" + vehicles[vehicle].name : "";
  }
  VehicleNames names() const;
  std::vector<std::uint8_t> systems() const;
  /// Headings of the vehicles at the start, in N.
  std::vector<double> start_yaws_rad() const;
  const base::ConfigNode& sensors_of(std::size_t vehicle) const;
  const Limits& limits_of(std::size_t vehicle) const;

  /// Reads and checks a scenario file. @throws base::ConfigError with file, line and key path
  static Scenario load(const std::filesystem::path& file);
};

/// Every key of Scenario with its default and meaning, as tables in Markdown: for `hils run --keys`
/// and docs/reference/config.md.
std::string scenario_reference();

}  // namespace cas::hils
