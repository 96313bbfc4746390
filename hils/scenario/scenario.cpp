// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/angles.hpp"
#include "base/config/file_kind.hpp"
#include "base/config/geodetic_keys.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/key_table.hpp"
#include "base/config/sensor_names.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"
#include "base/config/weather_keys.hpp"
#include "base/earth/wmm2025.hpp"
#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "hils/flight/phase_check.hpp"
#include "hils/scenario/figure.hpp"
#include "hils/scenario/handed_on_keys.hpp"
#include "hils/scenario/simulation_parts.hpp"
#include "plugins/fault/fault_spec.hpp"

namespace cas::hils {

namespace {

using base::block;
using base::HandedOn;
using base::key;
using base::Range;
using base::ReadApart;
using base::required;

// Limits

constexpr Range kBound{0, 1e9};
constexpr Range kShare_pct{0, 100};

using FigureRow = Figure<Measurement>;

constexpr std::tuple kLimitKeys{
    key<&Limits::lost>("lost", base::Count{}, "lost packets of each HIL message"),
    key<&Limits::delivered_pct>("delivered_pct", kShare_pct,
                                "least share of delivered packets of each HIL message"),
    key<&Limits::rate_error_pct>("rate_error_pct", kShare_pct,
                                 "deviation of the received rate from nominal, up or down"),
    key<&Limits::responses>("responses", ReadApart{"name -> block"},
                            "response to the `trajectory: {shape: step}` of that name", "none"),
};

/// Reads a bound for each figure of the table that has one.
/// @param name_of  the figure's key in the block, or BLOCK.KEY; empty: it cannot have one here
template <class Of, class NameOf>
FigureLimits parse_figures(const base::ConfigNode& node, const std::vector<Figure<Of>>& table,
                           const NameOf& name_of) {
  FigureLimits limits;
  for (const Figure<Of>& row : table) {
    const std::string name = name_of(row);
    if (name.empty()) continue;
    const std::size_t dot = name.find('.');
    const auto block = dot == name.npos ? std::optional(node) : node.find(name.substr(0, dot));
    const std::string key = name.substr(dot == name.npos ? 0 : dot + 1);
    if (!block || !block->has(key)) continue;
    if (row.better == Better::kNeither) {
      block->at(key).fail("this figure is not better up or down: it takes no limit");
    }
    limits[row.key] = block->require_in(key, kBound.low, kBound.high);
  }
  return limits;
}

/// The motion's limits are where summary.json has its figures, the others have the figures' keys.
std::string limit_name(const FigureRow& row) {
  return row.part == FigureRow::Part::kMotion ? row.place() : row.key;
}

bool has_response(const std::vector<FlightStep>& steps, std::string_view name) {
  return std::ranges::any_of(steps, [name](const FlightStep& step) {
    return step.trajectory.shape == fcu::PatternShape::kSteps && phase_of(step) == name;
  });
}

/// Each key is the name of a `trajectory: {shape: step}` of the flight.
std::map<std::string, FigureLimits> parse_responses(const base::ConfigNode& limits,
                                                    const std::vector<FlightStep>& steps) {
  std::map<std::string, FigureLimits> responses;
  const std::optional<base::ConfigNode> node = limits.find("responses");
  if (!node) return responses;
  for (const auto& [name, body] : node->entries()) {
    if (!has_response(steps, name))
      body.fail("the flight has no 'trajectory: {shape: step}' of that name");
    responses[name] =
        parse_figures(body, response_table(), std::mem_fn(&Figure<StepResponse>::key));
  }
  return responses;
}

/// Reads the block `limits`; its `responses` name steps of the flight.
Limits parse_limits(const base::ConfigNode& node, const std::vector<FlightStep>& steps) {
  Limits limits;
  base::read_keys(node, kLimitKeys, limits);
  limits.figures = parse_figures(node, figure_table(), limit_name);
  limits.responses = parse_responses(node, steps);
  return limits;
}

/// Reads the list `allow`: incidents that fail no run.
std::set<IncidentKind> parse_allow(const base::ConfigNode& root) {
  std::set<IncidentKind> allowed;
  const std::optional<base::ConfigNode> list = root.find("allow");
  if (!list) return allowed;
  for (const base::ConfigNode& node : list->items()) {
    const auto word = node.as<std::string>();
    const auto kind = kIncidentWords.find(word);
    if (!kind) {
      node.fail("'" + word +
                "' is no incident; there are ground, crash, attitude, flyaway and strike");
    }
    allowed.insert(*kind);
  }
  return allowed;
}

/// Limits of one vehicle of several: without responses to steps that others fly.
Limits limits_for(std::size_t vehicle, Limits limits, const std::vector<FlightStep>& steps) {
  const std::vector<FlightStep> own = steps_for(vehicle, steps);
  std::erase_if(limits.responses,
                [&own](const auto& response) { return !has_response(own, response.first); });
  return limits;
}

/// Each takes two of casd's links and an emulator of its own.
constexpr std::size_t kMostVehicles = 16;
constexpr std::size_t kLongestName = 24;  ///< it is a part of paths of sockets, which are short
constexpr double kFarthest_m = 10'000;

struct VehicleName : base::Text {
  static void read(const base::ConfigNode& node, std::string& name) {
    Text::read(node, name);
    const bool plain =
        std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
    if (name.empty() || name.size() > kLongestName || !plain) {
      node.fail("a vehicle's name is made of up to 24 letters, digits and underscores");
    }
  }
};

constexpr Range kPlace_m{-kFarthest_m, kFarthest_m};

constexpr std::tuple kPoseKeys{
    required(key<&VehiclePose::x_m>("x_m", kPlace_m, "east of home")),
    required(key<&VehiclePose::y_m>("y_m", kPlace_m, "north of home")),
    key<&VehiclePose::z_m>("z_m", kPlace_m, "height of its lowest point above z = 0",
                           "on the uppermost surface"),
    key<&VehiclePose::yaw_deg>("yaw_deg", Range{-360, 360},
                               "of the nose, counter-clockwise from east"),
};

void check_apart(const base::ConfigNode& node, const std::vector<ScenarioVehicle>& vehicles) {
  constexpr double kLeast_m = 1;  // two quadrotors that touch each other fly nowhere
  const ScenarioVehicle& last = vehicles.back();
  for (std::size_t i = 0; i + 1 < vehicles.size(); ++i) {
    const VehiclePose& other = vehicles[i].pose;
    if (std::hypot(last.pose.x_m - other.x_m, last.pose.y_m - other.y_m) >= kLeast_m) continue;
    node.at("pose").fail("stands less than 1 m from '" + vehicles[i].name + "'");
  }
}

/// A sensor set for the programs, which is read here for its errors.
struct Sensors : HandedOn {
  template <class T>
  requires std::is_assignable_v<T&, const base::ConfigNode&>
  static void read(const base::ConfigNode& node, T& sensors) {
    HandedOn::read(node, sensors);
    base::sensor_set(node);
  }
};

constexpr auto kPose = block<VehiclePose>(kPoseKeys);

constexpr std::tuple kVehicleKeys{
    required(key<&ScenarioVehicle::name>("name", VehicleName{},
                                         "up to 24 letters, digits and underscores")),
    required(key<&ScenarioVehicle::vehicle>("vehicle", ReadApart{"file"}, "vehicle file")),
    required(key<&ScenarioVehicle::pose>("pose", kPose,
                                         "its start; at least 1 m from the next vehicle")),
    key<&ScenarioVehicle::sensors>("sensors", Sensors{}, "replaces the scenario's sensor set",
                                   "the scenario's"),
    key<&ScenarioVehicle::controller>("controller", HandedOn{},
                                      "keys of its controller file; override the scenario's"),
    key<&ScenarioVehicle::limits>("limits", ReadApart{"block"},
                                  "its own limits; override the scenario's", "the scenario's"),
};

ScenarioVehicle parse_alone(const base::ConfigNode& root) {
  ScenarioVehicle vehicle;
  vehicle.vehicle = base::find_config(root.at("vehicle"));
  vehicle.system_id = base::Vehicle::load(vehicle.vehicle).system_id;
  if (const auto pose = root.find("pose")) kPose.read(*pose, vehicle.pose);
  return vehicle;
}

ScenarioVehicle parse_one(const base::ConfigNode& node,
                          const std::vector<ScenarioVehicle>& before) {
  ScenarioVehicle vehicle;
  base::read_keys(node, kVehicleKeys, vehicle);
  if (std::ranges::count(before, vehicle.name, &ScenarioVehicle::name) > 0) {
    node.at("name").fail("two vehicles have the name '" + vehicle.name + "'");
  }
  vehicle.vehicle = base::find_config(node.at("vehicle"));
  vehicle.system_id = static_cast<std::uint8_t>(before.size() + 1);
  return vehicle;
}

/// Reads `vehicle`, or the list `vehicles`.
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

/// Reads the limits of each vehicle of several; one alone has those of the scenario.
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

constexpr int kScenarioSchema = 1;

/// Folders beside the file, by their whole paths.
struct Folders {
  static void read(const base::ConfigNode& node, std::vector<std::filesystem::path>& folders) {
    for (const auto& folder : node.as<std::vector<std::string>>()) {
      folders.push_back(std::filesystem::weakly_canonical(node.resolve(folder)));
    }
  }
};

constexpr std::tuple kVehiclesKeys{
    key<&Scenario::vehicles>("vehicle", ReadApart{"file"}, "vehicle file", "or `vehicles`"),
    key<&Scenario::vehicles>("vehicles", ReadApart{"list"}, "[several](#several-vehicles)",
                             "or `vehicle`"),
    key<&Scenario::vehicles>("pose", ReadApart{"block"},
                             "start of a single vehicle, with the keys of one of several",
                             "home, the nose to the north"),
};

constexpr std::tuple kWorldKeys{
    key<&Scenario::world, &ScenarioWorld::sdf>(
        "world", ReadApart{"file"},
        "SDF file as [a simulation's](../use/simulator.md#worlds), with its gravity, wind and "
        "obstacles; "
        "`config/scenarios/village.yaml` has one. Its real-time factor and step are ignored",
        "flat ground"),
    key<&Scenario::world, &ScenarioWorld::model_path>("model_path", Folders{},
                                                      "as in a [simulation](#simulation)"),
    key<&Scenario::world, &ScenarioWorld::ignore_missing>(
        "missing",
        base::Words<bool, 2>{{{{"error", false}, {"ignore", true}}}, "is error or ignore"},
        "as in a [simulation](#simulation)"),
    key<&Scenario::world, &ScenarioWorld::applies_up_axis>(
        "collada_up_axis",
        base::Words<bool, 2>{{{{"ignored", false}, {"applied", true}}}, "is ignored or applied"},
        "as in a [simulation](#simulation)"),
};

/// Elevation files and folders of them, by their whole paths.
struct ElevationFiles {
  static void read(const base::ConfigNode& node, std::vector<std::filesystem::path>& files) {
    if (node.items().empty()) node.fail("names no file");
    for (const base::ConfigNode& item : node.items()) {
      const std::filesystem::path file = item.resolve(item.as<std::string>());
      if (!std::filesystem::exists(file)) item.fail("there is no file or folder " + file.string());
      files.push_back(std::filesystem::weakly_canonical(file));
    }
  }
};

constexpr std::tuple kTerrainKeys{
    required(key<&ScenarioTerrain::files>("files", ElevationFiles{},
                                          "list of elevation files (.hgt, .tif) and folders of "
                                          "them")),
    key<&ScenarioTerrain::geoid>("geoid", base::PathBeside{},
                                 "elevation file of the geoid over the ellipsoid, for elevations "
                                 "over the ellipsoid"),
};
constexpr std::tuple kGroundKeys{
    key<&Scenario::world, &ScenarioWorld::terrain>(
        "terrain", base::block<ScenarioTerrain>(kTerrainKeys),
        "[ground from elevation files](../use/simulator.md#terrain); goes with `home`", "none"),
};

/// Reads `world`, and the keys that have a meaning beside it. @throws base::ConfigError when there
/// is no such file
void parse_world(const base::ConfigNode& root, Scenario& scenario) {
  base::read_keys(root, kGroundKeys, scenario);
  const std::optional<base::ConfigNode> node = root.find("world");
  if (!node) return;
  if (!node->is_scalar()) {
    node->fail("is the name of an SDF file; without it a scenario has flat ground");
  }
  scenario.world.sdf = base::find_config(*node);
  base::read_keys(root, kWorldKeys, scenario);
}

struct ArchitectureWord {
  static void read(const base::ConfigNode& node, Architecture& architecture) {
    try {
      architecture = parse_architecture(node.as<std::string>());
    } catch (const base::ConfigError& error) {
      node.fail(error.what());
    }
  }
  static std::string text(Architecture architecture) {
    return std::string(to_string(architecture));
  }
  static std::string values() { return "tcas, loop, ts, sitl, direct"; }
  static std::array<std::string, 2> samples() { return {"direct", "tcas"}; }
};

struct Plugins {
  static void read(const base::ConfigNode& node, std::vector<base::ConfigNode>& plugins) {
    plugins = node.items();
    node.mark_used();
  }
};

constexpr auto kPlaceKeys = base::geodetic_keys(-500, 9000);
constexpr Range kSensorRate_hz{50, 2000};
constexpr Range kControlRate_hz{50, 1000};  // of the controller
constexpr Range kFieldYears{base::wmm2025::kEpochYear, base::wmm2025::kLastYear};

constexpr std::tuple kRateKeys{
    required(key<&Rates::sensor_hz>("sensor_hz", kSensorRate_hz,
                                    "nominal rate of HIL_SENSOR; no more than the steps of "
                                    "`step_us`")),
    required(key<&Rates::gps_hz>("gps_hz", Range{1, 50}, "of HIL_GPS")),
    required(key<&Rates::controls_hz>("controls_hz", kControlRate_hz,
                                      "of the controls; no more than `sensor_hz`")),
};

/// Keys of every scenario that names its vehicles.
constexpr std::tuple kPlaceAndTimeKeys{
    key<&Scenario::name>("name", base::Text{}, "for reports", "file name"),
    key<&Scenario::description>("description", base::Text{}, "for reports"),
    key<&Scenario::home>("home", block<base::Geodetic>(kPlaceKeys),
                         "place of x = y = z = 0; required on flat ground", "the world's"),
    key<&Scenario::decimal_year>("decimal_year", kFieldYears, "date of the magnetic field model"),
    key<&Scenario::weather>("weather", base::kWeatherBlock,
                            "[air of the day](#weather), for barometer and rotors", "the world's"),
    key<&Scenario::seed>("seed", base::Count{},
                         "seed of all random numbers; `--seed` overrides it"),
    key<&Scenario::step_us>("step_us", base::Whole{100, 10'000}, "physics step"),
};

constexpr std::tuple kKeys{
    key<&Scenario::architecture>("architecture", ArchitectureWord{},
                                 "see below; `--architecture` overrides it"),
    key<&Scenario::integrator>("integrator",
                               base::Words<std::string_view, 2>{{{{"rk4", "rk4"}, {"ode", "ode"}}},
                                                                "the integrator is rk4 or ode"},
                               "as in a [simulation](#simulation)"),
    required(key<&Scenario::rates>("rates", block<Rates>(kRateKeys), "of the HIL stream")),
    key<&Scenario::line>("line", HandedOn{},
                         "the [serial line](#serial-line) between casd and the controller",
                         "{preset: ideal}"),
    key<&Scenario::controller>("controller", HandedOn{},
                               "keys of the [controller](#controller) file: `stamp`, `actuators`, "
                               "`params`, ...; those that hils sets itself are refused"),
    key<&Scenario::sensors>(
        "sensors", Sensors{},
        "the [sensor set](../use/plugins.md#sensor-sets) of simulator and controller: `sensors: "
        "rtk`, or "
        "with changes `{preset: rtk, gps: {delay_s: 0.2}}`; IMU and GPS take their rates from "
        "`rates`",
        "the vehicle's"),
    key<&Scenario::plugins>(
        "plugins", Plugins{},
        "additional plugins of each vehicle, each `{plugin: NAME, ...}`; MAVLink messages that "
        "they [declare](../use/plugins.md#sending-to-the-controller) reach the controller"),
    key<&Scenario::wake_up>("wake_up", base::Parsed<parse_wake_up>{},
                            "`{p50_us, p99_us}`, virtual clock: wake-up delay of casd's threads "
                            "(log-normal)",
                            "0, 0"),
    key<&Scenario::drain_tick_ms>("drain_tick_ms", Range{0, 10},
                                  "casd's key of this name, for architecture `ts`"),
    key<&Scenario::ground_station>(
        "ground_station", base::Flag{},
        "a ground station that listens, sends sticks (centred but for step `sticks`) and loads the "
        "parameters every 20 s, for each vehicle"),
    required(key<&Scenario::steps>("steps", ReadApart{"list"}, "the flight, see below")),
    key<&Scenario::faults>("faults", ReadApart{"list"}, "[faults](#faults) during the flight",
                           "none"),
    key<&Scenario::limits>("limits", ReadApart{"block"}, "pass criteria, see below", "none"),
    key<&Scenario::limits, &Limits::allow>(
        "allow", ReadApart{"ground, crash, attitude, flyaway, strike"},
        "a list of the [incidents](#incidents) that do not fail the run", "none"),
};

}  // namespace

bool has_sticks(const Scenario& scenario) {
  return scenario.ground_station || std::ranges::any_of(scenario.steps, [](const FlightStep& step) {
           return step.kind == StepKind::kSticks;
         });
}

void check_silences(const base::ConfigNode& faults, const Scenario& scenario) {
  for (const base::ConfigNode& fault : faults.items()) {
    const auto silence = fault.find("silence");
    if (!silence) continue;
    if (scenario.firmware && silence->as<std::string>() == "ground") {
      silence->fail("a flight of stock firmware does not have this fault");
    }
    if (silence->as<std::string>() == "sticks" && !has_sticks(scenario)) {
      silence->fail("no sticks can be lost: no step `sticks`, and no `ground_station: true`");
    }
  }
}

namespace {

/// Our controller's sticks are those of the ground station. @throws base::ConfigError
void check_sticks(const base::ConfigNode& steps, const Scenario& scenario) {
  if (scenario.ground_station) return;
  for (const base::ConfigNode& step : steps.items()) {
    if (step.is_map() && step.has("sticks")) {
      step.at("sticks").fail("needs `ground_station: true`, which sends them");
    }
  }
}

}  // namespace

void check_fault_plugins(const std::set<std::string>& plugins,
                         const std::vector<VehicleFault>& faults) {
  std::size_t number = 0;
  for (const VehicleFault& fault : faults) {
    const std::string needed = sim::needed_plugin(sim::parse_fault(fault.script, ++number).kind);
    if (needed.empty() || plugins.contains(needed)) continue;
    fault.script.fail("needs 'plugin: " + needed +
                      "', which this vehicle does not have: it would begin and do nothing");
  }
}

bool has_wing(const ScenarioVehicle& vehicle) {
  return base::ConfigNode::load(vehicle.vehicle).has(kAeroPlugin);
}

std::set<std::string> plugins_of(const Scenario& scenario, std::size_t vehicle) {
  std::set<std::string> plugins = plugin_names(scenario.plugins);
  if (scenario.firmware) {
    const base::ConfigNode own = scenario.firmware->world.at("vehicles").items().at(vehicle);
    plugins.merge(plugin_names(own.at("plugins").items()));
    return plugins;
  }
  plugins.insert({"motor", "imu", "gps", "magnetometer", "barometer"});
  if (has_wing(scenario.vehicles.at(vehicle))) plugins.insert("aero");
  for (std::string& name : further_first_sensors(flown_sensors(scenario, vehicle))) {
    plugins.insert(std::move(name));
  }
  return plugins;
}

std::set<std::string> plugin_names(const std::vector<base::ConfigNode>& plugins) {
  std::set<std::string> names;
  for (const base::ConfigNode& plugin : plugins) {
    const auto name = plugin.get<std::string>("plugin", "");
    names.insert(base::sensor_name(name, base::sensor_number(plugin, name)));
  }
  return names;
}

double ScenarioVehicle::start_yaw_rad() const {
  constexpr double kNorthDeg = 90;
  return std::remainder(base::radians(kNorthDeg - pose.yaw_deg), 2 * M_PI);
}

std::string title_of(Architecture architecture) { return base::upper(to_string(architecture)); }

Architecture parse_architecture(std::string_view word) {
  if (const auto architecture = kArchitectureWords.find(word)) return *architecture;
  throw base::ConfigError("there is no architecture '" + std::string(word) +
                          "'; there are direct, sitl, ts, loop and tcas" +
                          base::did_you_mean(word, kArchitectureWords.words));
}

VehicleNames Scenario::names() const {
  VehicleNames names;
  names.reserve(vehicles.size());
  for (const ScenarioVehicle& vehicle : vehicles) names.push_back(vehicle.name);
  return names;
}

std::vector<std::uint8_t> Scenario::systems() const {
  std::vector<std::uint8_t> systems;
  for (const ScenarioVehicle& vehicle : vehicles) systems.push_back(vehicle.system_id);
  return systems;
}

std::vector<double> Scenario::start_yaws_rad() const {
  std::vector<double> yaws;
  for (const ScenarioVehicle& vehicle : vehicles) yaws.push_back(vehicle.start_yaw_rad());
  return yaws;
}

const base::ConfigNode& Scenario::sensors_of(std::size_t vehicle) const {
  const std::optional<base::ConfigNode>& own = vehicles.at(vehicle).sensors;
  return own ? *own : sensors;
}

const Limits& Scenario::limits_of(std::size_t vehicle) const {
  const std::optional<Limits>& own = vehicles.at(vehicle).limits;
  return own ? *own : limits;
}

namespace {

/// Reads the vehicles, their world and place. @throws base::ConfigError
void read_vehicles(const base::ConfigNode& root, Scenario& scenario) {
  scenario.vehicles = parse_vehicles(root);
  parse_world(root, scenario);
  if (scenario.world.sdf.empty()) root.at("home");  // says that it is missing
  base::read_keys(root, kPlaceAndTimeKeys, scenario);
}

/// Refuses faults of rotors and surfaces that a vehicle does not have. @throws base::ConfigError
void check_fault_parts(const Scenario& scenario) {
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    const base::Vehicle vehicle = base::Vehicle::load(scenario.vehicles[i].vehicle);
    for (const VehicleFault& fault : scenario.faults.of_vehicle(i)) {
      const std::string missing =
          sim::missing_part(sim::parse_fault(fault.script, 1).kind, vehicle);
      if (!missing.empty()) fault.script.fail(missing);
    }
  }
}

/// Reads the keys of a scenario that our controller flies. @throws base::ConfigError
void read_own(const base::ConfigNode& root, Scenario& scenario) {
  read_vehicles(root, scenario);
  base::read_keys(root, kKeys, scenario);
  const double steps_hz = 1e6 / scenario.step_us;
  if (scenario.rates.sensor_hz > steps_hz) {
    root.at("rates")
        .at("sensor_hz")
        .fail(fmt::format("exceeds the simulation's own rate of {:g} Hz (step_us)", steps_hz));
  }
  if (scenario.rates.controls_hz > scenario.rates.sensor_hz) {
    root.at("rates").at("controls_hz").fail("controls answer HIL_SENSOR: no more than sensor_hz");
  }
  scenario.steps = parse_flight(root.at("steps"), casd::GainMap::shipped(), scenario.names());
  refuse_firmware_steps(root.at("steps"), std::ranges::all_of(scenario.vehicles, has_wing));
  check_sticks(root.at("steps"), scenario);
  check_handed_on_keys(scenario);
  if (!root.has("faults")) return;
  scenario.faults = parse_scenario_faults(root.at("faults"), scenario.line, scenario.names());
  refuse_faults(root.at("faults"), std::array<std::string_view, 2>{"pause", "cut"},
                "is a fault of a flight of stock firmware");
  check_silences(root.at("faults"), scenario);
  std::set<std::string> plugins;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    plugins.merge(plugins_of(scenario, i));
  }
  check_fault_plugins(plugins, scenario.faults.vehicle);
  check_fault_parts(scenario);
  check_fault_phases(root.at("faults"), scenario.steps);
}

}  // namespace

Scenario Scenario::load(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  if (root.require<int>("schema") != kScenarioSchema)
    root.at("schema").fail("this program reads schema 1");
  base::expect_file(root, base::FileKind::kScenario);
  Scenario scenario;
  scenario.file = file;
  scenario.name = root.get<std::string>("name", file.stem().string());
  scenario.description = root.get<std::string>("description", "");
  if (!root.has("firmware")) {
    read_own(root, scenario);
  } else {
    const bool names_vehicles = root.has("vehicle") || root.has("vehicles");
    if (names_vehicles) read_vehicles(root, scenario);
    read_firmware(root, scenario);
  }
  if (const auto limits = root.find("limits")) {
    const auto rates_hz = std::move(scenario.limits.rates_hz);
    scenario.limits = parse_limits(*limits, scenario.steps);
    scenario.limits.rates_hz = rates_hz;
  }
  parse_vehicle_limits(root, scenario.steps, scenario.vehicles);
  scenario.limits.allow = parse_allow(root);
  for (ScenarioVehicle& vehicle : scenario.vehicles) {
    if (vehicle.limits) vehicle.limits->allow = scenario.limits.allow;
  }
  root.reject_unused();
  return scenario;
}

std::string scenario_reference() {
  return base::key_table(
             std::tuple_cat(kVehiclesKeys, kWorldKeys, kGroundKeys, kPlaceAndTimeKeys, kKeys),
             Scenario{}) +
         "\nOne of `vehicles`:\n\n" + base::key_table(kVehicleKeys, ScenarioVehicle{}) +
         "\n`limits`:\n\n" + base::key_table(kLimitKeys, Limits{}) +
         "\nEach [figure](#figures) that is better down or up also has a limit, from 0 to 1e9: "
         "the most, or if better up the least, that passes. Its key is the figure's "
         "(`sensor_to_control_p99_us`); those of `rms` and `rms_estimate` are blocks "
         "(`rms: {x_m: 0.2}`), those of `responses` too "
         "(`responses: {NAME: {overshoot_pct: 20}}`).\n";
}

}  // namespace cas::hils
