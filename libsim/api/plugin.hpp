// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/figure.hpp"
#include "libsim/api/mavlink_message.hpp"
#include "libsim/api/topic_bus.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

/// One step of the simulation.
struct StepInfo {
  base::SimTime time;       ///< pre_step: start of the step; post_step: its end
  base::Duration dt{};      ///< length, the same in every step
  std::uint64_t index = 0;  ///< from 0 at time zero
};

/// Lets a plugin hold the clock in lockstep: the runner waits for it before each step.
class LockstepPeer {
 public:
  virtual ~LockstepPeer() = default;
  /// Blocks until every control that is due for sensors sent up to `time` has arrived.
  /// @return false on timeout or when interrupted: the runner then steps on and counts it
  virtual bool wait_for_controls(base::SimTime time, base::Duration timeout) = 0;
  /// Whether there is a peer to wait for. Without one (a flight controller that boots on the
  /// simulator's clock, or has gone), the simulation follows the wall clock.
  virtual bool in_step() const { return true; }
  /// The wait timed out and the simulation steps on: forget the answers that were due.
  virtual void give_up() {}
  /// Whether the newest sent data has been answered: nothing is in flight. Lockstep pauses at such
  /// a moment.
  virtual bool settled() const { return true; }
};

/// Argument of `configure`. It is valid during that call only; values that it returns stay valid.
class PluginContext {
 public:
  virtual ~PluginContext() = default;
  /// Topics are wired here, and only in `configure`.
  virtual TopicBus& bus() = 0;
  /// Full name of a vehicle's topic: "imu" -> "iris0/imu".
  virtual std::string topic(const std::string& name) const = 0;
  /// The vehicle that the plugin belongs to, as World knows it.
  virtual VehicleId vehicle_id() const = 0;
  /// The vehicle file of that vehicle.
  virtual const base::Vehicle& vehicle() const = 0;
  /// Name of that vehicle in the simulation: "iris0".
  virtual std::string vehicle_name() const = 0;
  /// Derived from the world's seed, the vehicle's name and the plugin's name.
  virtual std::uint64_t seed() const = 0;
  /// Length of a step.
  virtual base::Duration step() const = 0;
  /// Maps N about home to the Earth.
  virtual const base::LocalProjection& projection() const = 0;
  /// Decimal year of the simulated day, for the magnetic field.
  virtual double decimal_year() const = 0;
  /// Folder for the files of this run.
  virtual std::filesystem::path output_dir() const = 0;
  /// Adds a force to the vehicle for the life of the plugin, which owns the model.
  virtual void add_force_model(ForceModel& model) = 0;
  /// Makes the runner wait for this peer in lockstep. The plugin owns it.
  virtual void set_lockstep_peer(LockstepPeer& peer) = 0;
  /// Where the plugin publishes the MAVLink messages that its CAS_PLUGIN_SENDS declares; they leave
  /// by the vehicle's mavlink_interface. Once. A host without one drops them.
  /// @throws base::ConfigError when it declares none
  virtual Publisher<MavlinkMessage> mavlink() {
    return Publisher<MavlinkMessage>(std::make_shared<detail::Topic>());
  }
  /// The vehicle's plugins that declare MAVLink messages: for a plugin that sends them.
  virtual std::vector<MavlinkSender> mavlink_senders() const { return {}; }
  /// A figure of the plugin for the summary and the report of a run. Its name is unique within the
  /// plugin. A host without a report drops it.
  /// @param name  1 to 48 bytes of UTF-8 without control characters: "voltage"
  /// @param unit  0 to 48 of them: "V"
  /// @throws base::ConfigError for another name or unit, and beyond 64 figures
  virtual Publisher<FigureSample> figure(const std::string& name, const std::string& unit,
                                         FigureKind kind = FigureKind::kSeries) {
    (void)name, (void)unit, (void)kind;
    return Publisher<FigureSample>(std::make_shared<detail::Topic>());
  }
  /// The plugin casts many rays (World::cast): the world prepares for them before time zero.
  virtual void expect_rays() {}
};

/// A part of the simulation that lives in a shared library: a sensor, a force, an interface to a
/// controller. SimRunner makes one for each plugin that a vehicle of the simulation file lists.
///
/// create -> configure -> bus frozen -> (pre_step -> physics -> post_step)* -> finish -> destroy.
/// All on one thread. For example plugin `imu` advertises topic `iris0/imu` in configure(), and
/// publishes a sample in each post_step() in which one is due.
class Plugin {
 public:
  virtual ~Plugin() = default;
  /// Reads parameters, wires topics, registers forces. @throws base::ConfigError, best by
  /// `params.fail()`
  virtual void configure(PluginContext& context, const base::ConfigNode& params) = 0;
  /// Before the physics: sets wind and extra forces, takes commands. Must not block or allocate.
  virtual void pre_step(const StepInfo&, World&) {}
  /// After the physics: reads the new state, publishes. Must not block or allocate.
  virtual void post_step(const StepInfo&, const World&) {}
  /// Back to time zero with the same seed.
  virtual void reset() = 0;
  /// The run has ended normally: write pending output.
  virtual void finish() {}
  /// Figures for `--stats` and `sim.stats`: one JSON object as text, or nothing.
  virtual std::string stats_json() const { return {}; }
};

/// Result of a plugin library's entry point. Plain data, so that any build can read it.
struct PluginDescriptor {
  std::size_t struct_size;   ///< sizeof(PluginDescriptor) in the plugin's build
  const char* name;          ///< as in CAS_PLUGIN, and lib<name>.so
  const char* abi_tag;       ///< CAS_ABI_TAG of the plugin's build
  Plugin* (*create)();       ///< a new plugin, owned by the caller
  void (*destroy)(Plugin*);  ///< destroys a plugin of create()
};

/// Compiler, C++ ABI, Eigen alignment and sanitizer, which must agree between host and plugin, and
/// the version of the plugin interface: a host takes plugins of its own version.
#define CAS_STRINGIZE_(x) #x
#define CAS_STRINGIZE(x) CAS_STRINGIZE_(x)
#if defined(__clang__)
#define CAS_ABI_COMPILER "clang" CAS_STRINGIZE(__clang_major__)
#else
#define CAS_ABI_COMPILER "gcc" CAS_STRINGIZE(__GNUC__)
#endif
#if defined(__SANITIZE_ADDRESS__)
#define CAS_ABI_SANITIZER "address"
#elif defined(__SANITIZE_THREAD__)
#define CAS_ABI_SANITIZER "thread"
#elif defined(__has_feature)  // Clang has no such macros
#if __has_feature(address_sanitizer)
#define CAS_ABI_SANITIZER "address"
#elif __has_feature(thread_sanitizer)
#define CAS_ABI_SANITIZER "thread"
#endif
#endif
#ifndef CAS_ABI_SANITIZER
#define CAS_ABI_SANITIZER "none"
#endif
/// Raised when PluginContext, World or Plugin gain functions (an older host lacks them and must
/// refuse a plugin that may call them) and when base::Vehicle changes.
#define CAS_ABI_VERSION "0.7"
#define CAS_ABI_BUILD                                                                          \
  CAS_ABI_COMPILER ";cxx11abi=" CAS_STRINGIZE(_GLIBCXX_USE_CXX11_ABI) ";eigen=" CAS_STRINGIZE( \
      EIGEN_MAX_ALIGN_BYTES) ";sanitizer=" CAS_ABI_SANITIZER
#define CAS_ABI_TAG CAS_ABI_BUILD ";cas=" CAS_ABI_VERSION

}  // namespace cas::sim

/// Makes `Type` the plugin of this library. The one symbol that a plugin exports is cas_plugin_v1.
#define CAS_PLUGIN(Type, plugin_name)                                                   \
  extern "C" __attribute__((visibility("default"))) const ::cas::sim::PluginDescriptor* \
  cas_plugin_v1() {                                                                     \
    static const ::cas::sim::PluginDescriptor descriptor{                               \
        sizeof(::cas::sim::PluginDescriptor), plugin_name, CAS_ABI_TAG,                 \
        []() -> ::cas::sim::Plugin* { return new Type(); },                             \
        [](::cas::sim::Plugin* plugin) { delete plugin; }};                             \
    return &descriptor;                                                                 \
  }
