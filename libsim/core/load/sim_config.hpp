// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"
#include "base/earth/geodesy.hpp"
#include "base/earth/weather.hpp"
#include "base/os/thread.hpp"
#include "base/time/clock.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/mesh_options.hpp"
#include "libsim/core/terrain/terrain_config.hpp"

namespace cas::sim {

/// Condition for which the simulation waits before a step.
enum class PaceMode {
  kRealtime,  ///< the wall clock
  kLockstep,  ///< the controls that are due
  kFreeRun,   ///< nothing
};

/// Integrator of free flight.
enum class Integrator {
  kRk4,  ///< ours, fourth order; ODE only while in contact
  kOde,  ///< ODE's first-order stepper throughout, for comparison
};

/// How fast simulated time runs against the wall clock, and how late steps are made up for.
struct PaceConfig {
  PaceMode mode = PaceMode::kRealtime;
  bool speed_given = false;  ///< else an SDF world's real-time factor holds
  /// Simulated seconds per second of wall clock. lockstep uses it only when it is given.
  double speed = 1.0;
  double catch_up_rate = 1.25;  ///< fastest pace, as a multiple of `speed`, after a late step
  base::Duration max_lag = std::chrono::milliseconds(250);  ///< lag beyond this is given up
  /// Wall clock that a late wake-up may make up for at once, in a burst.
  base::Duration largest_burst = std::chrono::milliseconds(10);
  base::Duration lockstep_timeout = std::chrono::seconds(1);
  base::ThreadOptions thread{};             ///< of the simulation thread
  std::optional<int> cpu_dma_latency_us{};  ///< base::CpuLatencyRequest
};

/// Handling of a world that names a missing model or mesh.
enum class Missing {
  kError,   ///< it is refused
  kIgnore,  ///< it is flown in without them, with a warning for each
};

struct WorldConfig {
  std::optional<std::filesystem::path> sdf;       ///< replaces the keys below
  std::vector<std::filesystem::path> model_path;  ///< where model:// URIs are looked up
  Missing missing = Missing::kError;
  UpAxis up_axis = UpAxis::kIgnored;  ///< of COLLADA meshes, also of vehicles
  double gravity_m_s2 = 0;
  bool ground = true;  ///< a horizontal plane at z = 0
};

/// Where a vehicle starts, in W.
struct StartPose {
  double x_m = 0;
  double y_m = 0;
  std::optional<double> z_m{};  ///< of its lowest point; nullopt: on the uppermost surface
  double yaw_deg = 0;           ///< of the nose, counter-clockwise from east
};

/// A plugin in a vehicle's list, with its parameters.
struct PluginConfig {
  std::string plugin;  ///< bare library name
  base::ConfigNode params =
      base::ConfigNode::empty();  ///< merged over sensors.<plugin> of the vehicle file
};

/// A vehicle of a simulation file, with its plugins.
struct VehicleConfig {
  std::string name;
  base::Vehicle vehicle;
  StartPose pose;
  std::vector<PluginConfig> plugins;
};

/// A beacon, by which vehicles may land.
struct BeaconConfig {
  base::ConfigNode node = base::ConfigNode::empty();  ///< for messages
  std::string name;
  std::optional<std::string> on;  ///< moving obstacle that carries it; nullopt: it stands in W
  double x_m = 0;                 ///< in W, or in the obstacle's own axes
  double y_m = 0;
  std::optional<double> z_m;  ///< nullopt: on the uppermost surface
};

/// Complete configuration of one run, read from a hilsim configuration file.
struct CAS_SIM_EXPORT SimConfig {
  static constexpr int kSchema = 1;

  WorldConfig world;
  std::optional<TerrainConfig> terrain;
  std::optional<base::Geodetic> home;  ///< empty: the SDF world's spherical coordinates
  double decimal_year = 0;
  base::Weather weather;
  std::optional<base::Duration> step;  ///< empty: the SDF world's, else 1 ms
  PaceConfig pace;
  std::uint64_t seed = 1;
  Integrator integrator = Integrator::kRk4;
  std::vector<BeaconConfig> beacons;
  std::vector<VehicleConfig> vehicles;

  /// @throws base::ConfigError with file, line and key path
  static SimConfig load(const std::filesystem::path& file);
  static SimConfig parse(const base::ConfigNode& root);
};

/// Options outside the world's configuration, set by flags.
struct SimOptions {
  std::filesystem::path output_dir = ".";
  std::vector<std::filesystem::path>
      plugin_dirs;  ///< searched before CAS_PLUGIN_PATH and the install folder
};

}  // namespace cas::sim
