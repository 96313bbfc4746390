// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "libsim/api/plugin.hpp"
#include "libsim/core/run/figure_book.hpp"
#include "libsim/core/run/plugin_loader.hpp"
#include "libsim/core/run/sim_world.hpp"

namespace cas::sim {

/// Context shared by all plugins of a run.
struct PluginSurroundings {
  TopicBus& bus;
  SimWorld& world;
  base::Duration step;
  std::uint64_t seed;  ///< of the world
  std::filesystem::path output_dir;
};

/// One plugin of one vehicle.
struct PluginInstance {
  std::string label;  ///< "imu@iris0"
  VehicleId vehicle{};
  PluginPtr plugin;
  std::string name;                ///< the label without the vehicle: "imu", or "imu#2" for a twin
  std::vector<std::string> sends;  ///< MAVLink messages that it declares
};

/// The plugins of a world in the order in which they are stepped.
class PluginHost {
 public:
  explicit PluginHost(std::vector<std::filesystem::path> plugin_dirs)
      : loader_(std::move(plugin_dirs)) {}

  /// Creates the plugins of a vehicle. @throws base::ConfigError
  void load(VehicleId id, const VehicleConfig& vehicle);
  /// Configures all in order.
  /// @return labels of the plugins whose MAVLink messages no mavlink_interface sends
  /// @throws base::ConfigError that names the plugin and the vehicle
  std::vector<std::string> configure(const std::vector<VehicleConfig>& vehicles,
                                     const PluginSurroundings& around);

  void pre_step(const StepInfo& step, World& world) {
    for (const PluginInstance& p : plugins_) p.plugin->pre_step(step, world);
  }
  void post_step(const StepInfo& step, const World& world) {
    for (const PluginInstance& p : plugins_) p.plugin->post_step(step, world);
  }
  void reset() {
    for (const PluginInstance& p : plugins_) p.plugin->reset();
    figures_.reset();
  }
  void finish() {
    for (const PluginInstance& p : plugins_) p.plugin->finish();
  }

  const std::vector<PluginInstance>& plugins() const { return plugins_; }
  const std::vector<LockstepPeer*>& peers() const { return peers_; }
  /// Figures that the plugins publish.
  const FigureBook& figures() const { return figures_; }

 private:
  PluginLoader loader_;
  FigureBook figures_;  // outlives the plugins that publish
  std::vector<PluginInstance> plugins_;
  std::vector<LockstepPeer*> peers_;
};

}  // namespace cas::sim
