// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sim_config.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/config/install_paths.hpp"
#include "base/config/sensor_set.hpp"
#include "base/os/cpu_latency.hpp"
#include "base/suggestion.hpp"

namespace cas::sim {

namespace {

using base::ConfigNode;

/// The value that a word stands for; the error lists the words.
template <class T, std::size_t N>
T one_of(const ConfigNode& node, const std::array<std::pair<std::string_view, T>, N>& words) {
  const auto word = node.as<std::string>();
  std::string known;
  std::array<std::string_view, N> names;
  for (std::size_t i = 0; i < N; ++i) {
    names[i] = words[i].first;
    if (word == names[i]) return words[i].second;
    known += (known.empty() ? "" : ", ") + std::string(names[i]);
  }
  node.fail("'" + word + "' is none of: " + known + base::did_you_mean(word, names));
}

constexpr std::array<std::pair<std::string_view, PaceMode>, 3> kPaceModes{
    {{"realtime", PaceMode::kRealtime},
     {"lockstep", PaceMode::kLockstep},
     {"free_run", PaceMode::kFreeRun}}};
constexpr std::array<std::pair<std::string_view, Integrator>, 2> kIntegrators{
    {{"rk4", Integrator::kRk4}, {"ode", Integrator::kOde}}};

constexpr std::array<std::pair<std::string_view, Missing>, 2> kMissing{
    {{"error", Missing::kError}, {"ignore", Missing::kIgnore}}};

constexpr double kShortestStepUs = 100;
constexpr double kLongestStepUs = 10'000;

WorldConfig parse_world(const ConfigNode& node, const ConfigNode& root) {
  WorldConfig world;
  for (const auto& folder : root.get("model_path", std::vector<std::string>{})) {
    world.model_path.push_back(root.resolve(folder));
  }
  if (const auto word = root.find("missing")) world.missing = one_of(*word, kMissing);
  if (node.is_scalar()) {
    world.sdf = base::find_config(node);
    return world;
  }
  world.gravity_m_s2 = node.require_in("gravity_m_s2", 0.0, 100.0);
  world.ground = node.require<bool>("ground");
  return world;
}

base::Geodetic parse_home(const ConfigNode& node) {
  return {.lat_deg = node.require_in("lat_deg", -90, 90),
          .lon_deg = node.require_in("lon_deg", -180, 180),
          .alt_m = node.require_in("alt_m", -1000, 10'000)};
}

PaceConfig parse_pace(const ConfigNode& root) {
  using std::chrono::milliseconds;
  PaceConfig pace;
  if (const auto mode = root.find("pace")) pace.mode = one_of(*mode, kPaceModes);
  pace.speed_given = root.has("speed");
  pace.speed = root.get_in("speed", 1.0, 1e-3, 1e3);
  const auto node = root.find("pacing");
  if (!node) return pace;
  pace.catch_up_rate = node->get_in("catch_up_rate", pace.catch_up_rate, 1.0, 100.0);
  if (node->has("max_lag_ms")) {
    pace.max_lag = base::from_seconds(1e-3 * node->require_in("max_lag_ms", 1, 60'000));
  }
  if (node->has("largest_burst_ms")) {
    pace.largest_burst = base::from_seconds(1e-3 * node->require_in("largest_burst_ms", 0, 1000));
  }
  if (node->has("lockstep_timeout_ms")) {
    pace.lockstep_timeout =
        base::from_seconds(1e-3 * node->require_in("lockstep_timeout_ms", 1, 60'000));
  }
  if (const auto thread = node->find("thread")) pace.thread = base::parse_thread_options(*thread);
  pace.lock_memory = node->get("lock_memory", false);
  pace.cpu_dma_latency_us = base::parse_cpu_latency(*node);
  return pace;
}

StartPose parse_pose(const ConfigNode& node) {
  return {.x_m = node.get("x_m", 0.0),
          .y_m = node.get("y_m", 0.0),
          .z_m = node.get("z_m", 0.0),
          .yaw_deg = node.get("yaw_deg", 0.0)};
}

/// A block in `sensors` for a plugin that the vehicle does not have is a mistake.
void check_blocks(const ConfigNode& sensors, const std::vector<PluginConfig>& plugins) {
  if (!sensors.is_map()) return;
  for (const auto& [name, block] : sensors.entries()) {
    const auto is_it = [&, &name = name](const PluginConfig& p) { return p.plugin == name; };
    if (name == "preset" || std::any_of(plugins.begin(), plugins.end(), is_it)) continue;
    block.fail("the vehicle has no plugin '" + name + "'");
  }
}

/// A plugin's own keys, behind them what the sensor set says of it.
PluginConfig parse_plugin(const ConfigNode& node, const ConfigNode& sensors) {
  PluginConfig plugin;
  plugin.plugin = node.require<std::string>("plugin");
  const auto preset = sensors.find(plugin.plugin);
  plugin.params = preset ? node.merged_over(*preset) : node;
  return plugin;
}

VehicleConfig parse_vehicle(const ConfigNode& node) {
  VehicleConfig vehicle;
  vehicle.name = node.require<std::string>("name");
  if (vehicle.name.empty() || vehicle.name.find('/') != std::string::npos) {
    node.at("name").fail("a vehicle's name is not empty and has no '/'");
  }
  vehicle.vehicle = base::Vehicle::load(base::find_config(node.at("vehicle")));
  if (const auto pose = node.find("pose")) vehicle.pose = parse_pose(*pose);
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

}  // namespace

SimConfig SimConfig::load(const std::filesystem::path& file) {
  return parse(base::ConfigNode::load(file));
}

SimConfig SimConfig::parse(const base::ConfigNode& root) {
  SimConfig config;
  const auto schema = root.require<int>("schema");
  if (schema != kSchema) {
    root.at("schema").fail("is " + std::to_string(schema) + "; this program reads schema " +
                           std::to_string(kSchema));
  }
  config.world = parse_world(root.at("world"), root);
  if (const auto home = root.find("home")) config.home = parse_home(*home);
  if (!config.home && !config.world.sdf) root.at("home");  // says that it is missing
  config.decimal_year = root.require_in("decimal_year", 1900, 2100);
  if (root.has("step_us")) {
    const double step_us = root.require_in("step_us", kShortestStepUs, kLongestStepUs);
    config.step = base::from_seconds(1e-6 * step_us);
  }
  config.pace = parse_pace(root);
  config.seed = root.get("seed", std::uint64_t{1});
  if (const auto word = root.find("integrator")) config.integrator = one_of(*word, kIntegrators);
  parse_vehicles(root.at("vehicles"), config.vehicles);
  root.reject_unused();
  return config;
}

}  // namespace cas::sim
