// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/plugin_host.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/random.hpp"

namespace cas::sim {

namespace {

/// The context of one plugin of one vehicle during its configure().
class Context final : public PluginContext {
 public:
  Context(const PluginSurroundings& around, VehicleId id, const VehicleConfig& vehicle,
          std::uint64_t seed, std::vector<LockstepPeer*>& peers)
      : around_(around), id_(id), vehicle_(vehicle), seed_(seed), peers_(peers) {}

  TopicBus& bus() override { return around_.bus; }
  std::string topic(const std::string& name) const override { return vehicle_.name + "/" + name; }
  VehicleId vehicle_id() const override { return id_; }
  const base::Vehicle& vehicle() const override { return vehicle_.vehicle; }
  std::string vehicle_name() const override { return vehicle_.name; }
  std::uint64_t seed() const override { return seed_; }
  base::Duration step() const override { return around_.step; }
  const base::LocalProjection& projection() const override { return around_.world.projection(); }
  double decimal_year() const override { return around_.world.decimal_year(); }
  std::filesystem::path output_dir() const override { return around_.output_dir; }
  void add_force_model(ForceModel& model) override { around_.world.add_force_model(id_, model); }
  void set_lockstep_peer(LockstepPeer& peer) override { peers_.push_back(&peer); }

 private:
  const PluginSurroundings& around_;
  VehicleId id_;
  const VehicleConfig& vehicle_;
  std::uint64_t seed_;
  std::vector<LockstepPeer*>& peers_;
};

}  // namespace

void PluginHost::load(VehicleId id, const VehicleConfig& vehicle) {
  for (const PluginConfig& config : vehicle.plugins) {
    const std::string name = config.plugin + "@" + vehicle.name;
    const auto same = std::count_if(plugins_.begin(), plugins_.end(), [&](const PluginInstance& p) {
      return p.label.substr(0, p.label.find('#')) == name;
    });
    const std::string label = same == 0 ? name : name + "#" + std::to_string(same + 1);
    try {
      plugins_.push_back({label, id, loader_.create(config.plugin)});
    } catch (const base::ConfigError& error) {
      if (const auto key = config.params.find("plugin")) key->fail(error.what());
      throw;
    }
  }
}

void PluginHost::configure(const std::vector<VehicleConfig>& vehicles,
                           const PluginSurroundings& around) {
  std::size_t next = 0;
  for (const VehicleConfig& vehicle : vehicles) {
    for (const PluginConfig& config : vehicle.plugins) {
      const PluginInstance& instance = plugins_[next++];
      // The label's own part, "imu" or "imu#2", so that twins draw different numbers.
      std::string name = instance.label;
      name.erase(name.find('@'), vehicle.name.size() + 1);
      const auto seed = base::derive_seed(base::derive_seed(around.seed, vehicle.name), name);
      Context context(around, instance.vehicle, vehicle, seed, peers_);
      try {
        config.params.find("plugin");
        instance.plugin->configure(context, config.params);
        config.params.reject_unused();
      } catch (const base::CommandPortError& error) {
        throw base::CommandPortError("plugin " + instance.label + ": " + error.what());
      } catch (const base::ConfigError& error) {
        throw base::ConfigError("plugin " + instance.label + ": " + error.what());
      } catch (const std::exception& error) {
        throw base::ConfigError("plugin " + instance.label + ": configure failed: " + error.what());
      } catch (...) {
        throw base::ConfigError("plugin " + instance.label +
                                ": configure failed with an unknown exception");
      }
    }
  }
}

}  // namespace cas::sim
