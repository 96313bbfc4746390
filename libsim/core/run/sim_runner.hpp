// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/time/clock.hpp"
#include "libsim/api/topic_bus.hpp"
#include "libsim/api/world.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

struct VehicleModel;
struct WorldModel;

/// Figures of one plugin instance: "mavlink_interface@iris0" and its JSON object.
struct PluginFigures {
  std::string name;
  std::string json;
};

/// What a run does otherwise than its files say: left out, replaced, taken from elsewhere, or
/// hardly meant so.
struct SimWarning {
  std::string vehicle;  ///< its name; empty: the world
  std::string sentence;
};

/// One world with its vehicles and plugins, stepped by its caller. Reads no clock. hilsim steps it
/// by its pace, the virtual bench and the environment of hils by their own time.
///
///   construct --> bus() wiring by the host --> start() --> step() ... step() --> finish()
///                                                 ^ reset() ^
///
/// All calls on one thread; one runner per process at a time (ODE).
class CAS_SIM_EXPORT SimRunner {
 public:
  /// Loads world, vehicles and plugin libraries. @throws base::ConfigError
  explicit SimRunner(SimConfig config, SimOptions options = {});
  ~SimRunner();
  SimRunner(const SimRunner&) = delete;
  SimRunner& operator=(const SimRunner&) = delete;

  /// For the host's own publishers and subscriptions ("iris0/wire_out"), before start().
  TopicBus& bus();
  /// Configures the plugins of each vehicle in file order, then freezes the bus.
  /// @throws base::ConfigError
  void start();

  /// Advances simulated time by exactly one step. @throws LeftWorldError when a vehicle has fallen
  /// out of the world
  void step();
  /// Back to time zero with the same seed: the same run again, byte for byte.
  void reset();
  /// Tells the plugins that the run has ended in good order, and writes plugin_figures.json where
  /// they have figures. Once.
  void finish();

  base::SimTime time() const;  ///< end of the last step
  base::Duration step_size() const;
  std::uint64_t steps() const;
  const World& world() const;
  const SimConfig& config() const;
  /// The objects of the world; they never change.
  const WorldModel& world_model() const;
  /// The models of the vehicles, index = VehicleId; they never change.
  const std::vector<VehicleModel>& vehicle_models() const;
  std::vector<std::string> vehicle_names() const;  ///< index = VehicleId
  /// About the files; from start() on also about idle connections, after finish() about contacts.
  const std::vector<SimWarning>& warnings() const;
  /// Lockstep: waits for the controls that are due, then tells whether nothing is on its way
  /// between simulator and controllers. True at any time in the other modes, and when the wait was
  /// in vain.
  bool settled();
  /// Steps that went on without the controls they waited for (lockstep).
  std::uint64_t lockstep_timeouts() const;
  /// Whether all lockstep peers are there.
  bool peers_in_step() const;
  std::vector<PluginFigures> plugin_figures() const;

  /// Tells the plugins of all vehicles which part of the flight it is ("takeoff", "hold"): topic
  /// `flight_phase`. Names are cut to 31 characters.
  void set_flight_phase(std::string_view name);

  /// Ends a lockstep wait early when the flag is set; the flag must outlive the runner.
  void set_interrupt(const std::atomic<bool>* flag);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::sim
