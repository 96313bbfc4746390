// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sim_config.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/config/file_kind.hpp"
#include "base/config/geodetic_keys.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/key_table.hpp"
#include "base/config/removed_keys.hpp"
#include "base/config/sensor_names.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/weather_keys.hpp"
#include "base/earth/wmm2025.hpp"
#include "base/os/cpu_latency.hpp"
#include "base/os/thread_keys.hpp"
#include "base/suggestion.hpp"
#include "libsim/core/load/simulation_reference.hpp"

namespace cas::sim {

namespace {

using base::ConfigNode;

using base::block;
using base::key;
using base::Number;
using base::Range;
using base::ReadApart;
using base::required;

/// Words whose refusal names the nearest.
template <class T, std::size_t N>
struct NearWords : base::Words<T, N> {
  void read(const ConfigNode& node, T& value) const {
    const auto word = node.as<std::string>();
    std::array<std::string_view, N> names;
    for (std::size_t i = 0; i < N; ++i) names[i] = this->words[i].first;
    if (std::ranges::find(names, word) == names.end()) {
      node.fail("'" + word + "' is none of: " + this->values() + base::did_you_mean(word, names));
    }
    base::Words<T, N>::read(node, value);
  }
};

constexpr NearWords<PaceMode, 3> kPaceModes{{{{{"realtime", PaceMode::kRealtime},
                                               {"lockstep", PaceMode::kLockstep},
                                               {"free_run", PaceMode::kFreeRun}}}}};
constexpr NearWords<Integrator, 2> kIntegrators{
    {{{{"rk4", Integrator::kRk4}, {"ode", Integrator::kOde}}}}};
constexpr NearWords<Missing, 2> kMissing{
    {{{{"error", Missing::kError}, {"ignore", Missing::kIgnore}}}}};
constexpr NearWords<UpAxis, 2> kUpAxes{
    {{{{"ignored", UpAxis::kIgnored}, {"applied", UpAxis::kApplied}}}}};

/// Folders beside the file.
struct Folders {
  static void read(const ConfigNode& node, std::vector<std::filesystem::path>& folders) {
    for (const auto& folder : node.as<std::vector<std::string>>()) {
      folders.push_back(node.resolve(folder));
    }
  }
};

constexpr std::tuple kFlatWorldKeys{
    required(key<&WorldConfig::gravity_m_s2>("gravity_m_s2", Range{0, 100}, "downwards")),
    required(key<&WorldConfig::ground>("ground", base::Flag{}, "a horizontal plane at z = 0")),
};

/// Elevation files and folders of them, beside the file.
struct ElevationFiles {
  static void read(const ConfigNode& node, std::vector<std::filesystem::path>& files) {
    for (const ConfigNode& item : node.items()) {
      const std::filesystem::path& file = files.emplace_back(item.resolve(item.as<std::string>()));
      if (!std::filesystem::exists(file)) item.fail("there is no file or folder " + file.string());
    }
    if (files.empty()) node.fail("names no file");
  }
};

constexpr std::tuple kTerrainKeys{
    required(key<&TerrainConfig::files>(
        "files", ElevationFiles{}, "list of elevation files (.hgt, .tif) and folders of them")),
    key<&TerrainConfig::geoid>("geoid", base::PathBeside{},
                               "elevation file of the geoid over the ellipsoid, for elevations "
                               "over the ellipsoid"),
};

/// An SDF file, or a flat world.
struct WorldBlock : base::Block<WorldConfig, decltype(kFlatWorldKeys)> {
  void read(const ConfigNode& node, WorldConfig& world) const {
    if (!node.is_scalar()) return Block::read(node, world);
    world.sdf = base::find_config(node);
  }
};

constexpr std::tuple kPacingKeys{
    key<&PaceConfig::catch_up_rate>("catch_up_rate", Range{1, 100},
                                    "fastest pace after a late step: a burst would flood a line"),
    key<&PaceConfig::largest_burst>("largest_burst_ms", Range{0, 1000, 1e-3},
                                    "lateness that is made up in one burst"),
    key<&PaceConfig::max_lag>("max_lag_ms", Range{1, 60'000, 1e-3},
                              "lateness beyond this is not made up; the real-time factor shows it"),
    key<&PaceConfig::lockstep_timeout>("lockstep_timeout_ms", Range{1, 60'000, 1e-3},
                                       "longest wait for the controls that are due"),
    key<&PaceConfig::thread>("thread", block<base::ThreadOptions>(base::kThreadKeys),
                             "of the simulation"),
    key<&PaceConfig::cpu_dma_latency_us>("cpu_dma_latency_us",
                                         base::Whole{0, base::CpuLatencyRequest::kLongest_us},
                                         "as casd's; none: no limit on idle states"),
};

void refuse_lock_memory(const ConfigNode& node, const PaceConfig& /*pace*/) {
  base::refuse_removed(node,
                       {{"lock_memory", "memory is locked where `thread` has a fifo_priority"}});
}

constexpr Range kFieldYears{base::wmm2025::kEpochYear, base::wmm2025::kLastYear};
constexpr auto kPlaceKeys = base::geodetic_keys(-1000, 10'000);

constexpr std::tuple kKeys{
    required(key<&SimConfig::world>(
        "world", WorldBlock{{kFlatWorldKeys}},
        "an SDF file ([simulator.md](../use/simulator.md#worlds)), or a flat "
        "world")),
    key<&SimConfig::world, &WorldConfig::model_path>("model_path", Folders{},
                                                     "folders of the models of an SDF file"),
    key<&SimConfig::world, &WorldConfig::missing>(
        "missing", kMissing,
        "missing model or mesh of an SDF file: `ignore` warns and continues without it"),
    key<&SimConfig::world, &WorldConfig::up_axis>(
        "collada_up_axis", kUpAxes,
        "`<up_axis>` of COLLADA meshes, also of vehicles: `ignored` as by Gazebo and RViz, or "
        "`applied`"),
    key<&SimConfig::terrain>("terrain", block<TerrainConfig>(kTerrainKeys),
                             "[ground from elevation files](../use/simulator.md#terrain)", "none"),
    key<&SimConfig::home>("home", block<base::Geodetic>(kPlaceKeys),
                          "place of x = y = z = 0; required in a flat world", "the world's"),
    required(key<&SimConfig::decimal_year>("decimal_year", kFieldYears,
                                           "date of the magnetic field model")),
    key<&SimConfig::weather>("weather", base::kWeatherBlock,
                             "[air of the day](#weather), for barometer and rotors", "the world's"),
    key<&SimConfig::step>("step_us", Range{100, 10'000, 1e-6}, "physics step",
                          "the world's, else 1000"),
    key<&SimConfig::pace, &PaceConfig::mode>(
        "pace", kPaceModes,
        "`lockstep` waits for the controls that are due, `free_run` for nothing"),
    key<&SimConfig::pace, &PaceConfig::speed>(
        "speed", Range{1e-3, 1e3},
        "simulated seconds per second; without the key, lockstep runs as fast as it can"),
    key<&SimConfig::pace>("pacing", block<PaceConfig>(kPacingKeys, refuse_lock_memory), ""),
    key<&SimConfig::seed>("seed", base::Count{}, "seed of all random numbers"),
    key<&SimConfig::integrator>("integrator", kIntegrators, "of free flight"),
    key<&SimConfig::beacons>("beacons", ReadApart{"list"},
                             "by which plugin [landing_target](../use/plugins.md#landing_target) "
                             "guides a vehicle, see below",
                             "none"),
    required(key<&SimConfig::vehicles>("vehicles", ReadApart{"list"}, "see below")),
};

/// A name that becomes part of a topic's.
struct TopicName : base::Text {
  const char* whose;  ///< "a vehicle's"
  void read(const ConfigNode& node, std::string& name) const {
    Text::read(node, name);
    if (name.empty() || name.find('/') != std::string::npos) {
      node.fail(std::string(whose) + " name is not empty and has no '/'");
    }
  }
};

constexpr std::tuple kBeaconKeys{
    required(key<&BeaconConfig::name>("name", TopicName{{}, "a beacon's"},
                                      "one of its own, without '/'")),
    key<&BeaconConfig::x_m>("x_m", Number{}, "to the east; on an obstacle along its own axes"),
    key<&BeaconConfig::y_m>("y_m", Number{}, "to the north"),
    key<&BeaconConfig::z_m>("z_m", Number{}, "up; required on an obstacle",
                            "on the uppermost surface"),
    key<&BeaconConfig::on>("on", base::Text{},
                           "[moving obstacle](../use/simulator.md#moving-obstacles) that carries "
                           "it"),
};

constexpr std::tuple kPoseKeys{
    key<&StartPose::x_m>("x_m", Number{}, "to the east"),
    key<&StartPose::y_m>("y_m", Number{}, "to the north"),
    key<&StartPose::z_m>("z_m", Number{}, "height of its lowest point", "on the uppermost surface"),
    key<&StartPose::yaw_deg>("yaw_deg", Number{}, "of the nose, counter-clockwise from east"),
};

constexpr std::tuple kVehicleKeys{
    required(key<&VehicleConfig::name>("name", TopicName{{}, "a vehicle's"},
                                       "one of its own, without '/'")),
    required(key<&VehicleConfig::vehicle>("vehicle", ReadApart{"file"}, "vehicle file")),
    key<&VehicleConfig::pose>("pose", block<StartPose>(kPoseKeys), "where it starts"),
    key<&VehicleConfig::vehicle, &base::Vehicle::sensors>(
        "sensors", ReadApart{"a set, or keys of one"},
        "the [sensor set](../use/plugins.md#sensor-sets): `rtk`, or `{preset: rtk, imu: {...}}`",
        "the vehicle's"),
    key<&VehicleConfig::plugins>(
        "plugins", ReadApart{"list"},
        "each `{plugin: NAME, ...}`, run in this order; their keys "
        "override those of the same plugin in the sensor set; with "
        "`number: 2` a [second sensor](../use/plugins.md#several-of-a-kind)",
        "none"),
};

/// Name of a plugin in its vehicle: its own, or "imu_2".
std::string name_of(const PluginConfig& plugin) {
  return base::sensor_name(plugin.plugin, base::sensor_number(plugin.params, plugin.plugin));
}

/// A block in `sensors` for a plugin that the vehicle does not have is a mistake.
void check_blocks(const ConfigNode& sensors, const std::vector<PluginConfig>& plugins) {
  if (!sensors.is_map()) return;
  for (const auto& [name, block] : sensors.entries()) {
    const auto is_it = [&, &name = name](const PluginConfig& p) { return name_of(p) == name; };
    if (name == "preset" || std::any_of(plugins.begin(), plugins.end(), is_it)) continue;
    block.fail("the vehicle has no plugin '" + name + "'");
  }
}

/// A plugin's own keys, merged over its preset in the sensor set.
PluginConfig parse_plugin(const ConfigNode& node, const ConfigNode& sensors) {
  PluginConfig plugin;
  plugin.plugin = node.require<std::string>("plugin");
  plugin.params = node;
  const auto preset = base::sensor_block(sensors, name_of(plugin));
  if (preset) plugin.params = node.merged_over(*preset);
  return plugin;
}

VehicleConfig parse_vehicle(const ConfigNode& node) {
  VehicleConfig vehicle;
  base::read_keys(node, kVehicleKeys, vehicle);
  vehicle.vehicle = base::Vehicle::load(base::find_config(node.at("vehicle")));
  ConfigNode presets = vehicle.vehicle.sensors;
  if (const auto sensors = node.find("sensors")) presets = base::sensor_set(*sensors, presets);
  if (const auto plugins = node.find("plugins")) {
    for (const ConfigNode& plugin : plugins->items()) {
      vehicle.plugins.push_back(parse_plugin(plugin, presets));
      plugin.mark_used();  // the plugin's own keys are checked when it has read them
    }
  }
  if (const auto sensors = node.find("sensors")) check_blocks(*sensors, vehicle.plugins);
  return vehicle;
}

void parse_vehicles(const ConfigNode& list, std::vector<VehicleConfig>& vehicles) {
  for (const ConfigNode& node : list.items()) {
    vehicles.push_back(parse_vehicle(node));
    const auto same_name = [&](const VehicleConfig& v) { return v.name == vehicles.back().name; };
    if (std::count_if(vehicles.begin(), vehicles.end(), same_name) > 1) {
      node.at("name").fail("two vehicles have the name '" + vehicles.back().name + "'");
    }
  }
  if (vehicles.empty()) list.fail("names no vehicle");
}

void parse_beacons(const ConfigNode& list, std::vector<BeaconConfig>& beacons) {
  constexpr std::size_t kMostBeacons = 1000;
  for (const ConfigNode& node : list.items()) {
    if (beacons.size() == kMostBeacons) list.fail("has more than 1000 beacons");
    BeaconConfig beacon;
    base::read_keys(node, kBeaconKeys, beacon);
    beacon.node = node;
    if (beacon.on && !beacon.z_m) node.fail("needs z_m, in the axes of the obstacle");
    if (std::ranges::find(beacons, beacon.name, &BeaconConfig::name) != beacons.end()) {
      node.at("name").fail("two beacons have the name '" + beacon.name + "'");
    }
    beacons.push_back(std::move(beacon));
  }
}

}  // namespace

SimConfig SimConfig::load(const std::filesystem::path& file) {
  return parse(base::ConfigNode::load(file));
}

SimConfig SimConfig::parse(const base::ConfigNode& root) {
  SimConfig config;
  const auto schema = root.require<int>("schema");
  if (schema != kSchema) {
    root.at("schema").fail(fmt::format("is {}; this program reads schema {}", schema, kSchema));
  }
  base::expect_file(root, base::FileKind::kWorld);
  base::read_keys(root, kKeys, config);
  if (!config.home && !config.world.sdf) root.at("home");  // says that it is missing
  if (config.terrain && !config.world.sdf && config.world.ground) {
    root.at("world").at("ground").fail("the terrain is the ground: give false");
  }
  config.pace.speed_given = root.has("speed");
  if (const auto beacons = root.find("beacons")) parse_beacons(*beacons, config.beacons);
  parse_vehicles(root.at("vehicles"), config.vehicles);
  root.reject_unused();
  return config;
}

std::string simulation_reference() {
  return base::key_table(kKeys, SimConfig{}) + "\nOne of `beacons`:\n\n" +
         base::key_table(kBeaconKeys, BeaconConfig{}) + "\nOne of `vehicles`:\n\n" +
         base::key_table(kVehicleKeys, VehicleConfig{});
}

}  // namespace cas::sim
