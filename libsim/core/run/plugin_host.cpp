// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/plugin_host.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/config/sensor_names.hpp"
#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/os/disk_error.hpp"
#include "base/random.hpp"

namespace cas::sim {

namespace {

std::string mavlink_topic(const VehicleConfig& vehicle, const PluginInstance& plugin) {
  return vehicle.name + "/mavlink/" + plugin.name;
}

/// The context of one plugin of one vehicle during its configure().
class Context final : public PluginContext {
 public:
  /// The host's lists of all plugins.
  struct Host {
    const std::vector<PluginInstance>& plugins;
    std::vector<LockstepPeer*>& peers;
    FigureBook& figures;
  };

  Context(const PluginSurroundings& around, const PluginInstance& instance,
          const VehicleConfig& vehicle, std::uint64_t seed, Host host)
      : around_(around), instance_(instance), vehicle_(vehicle), seed_(seed), host_(host) {}

  TopicBus& bus() override { return around_.bus; }
  std::string topic(const std::string& name) const override { return vehicle_.name + "/" + name; }
  VehicleId vehicle_id() const override { return instance_.vehicle; }
  const base::Vehicle& vehicle() const override { return vehicle_.vehicle; }
  std::string vehicle_name() const override { return vehicle_.name; }
  std::uint64_t seed() const override { return seed_; }
  base::Duration step() const override { return around_.step; }
  const base::LocalProjection& projection() const override { return around_.world.projection(); }
  double decimal_year() const override { return around_.world.decimal_year(); }
  std::filesystem::path output_dir() const override { return around_.output_dir; }
  void add_force_model(ForceModel& model) override {
    around_.world.add_force_model(instance_.vehicle, model);
  }
  void set_lockstep_peer(LockstepPeer& peer) override { host_.peers.push_back(&peer); }
  void expect_rays() override { around_.world.expect_rays(); }

  Publisher<MavlinkMessage> mavlink() override {
    if (instance_.sends.empty()) {
      throw base::ConfigError(
          "sends MAVLink messages and declares none: CAS_PLUGIN_SENDS(\"NAME\") beside CAS_PLUGIN");
    }
    sent_ = around_.bus.advertise<MavlinkMessage>(mavlink_topic(vehicle_, instance_));
    return *sent_;
  }

  std::vector<MavlinkSender> mavlink_senders() const override {
    std::vector<MavlinkSender> senders;
    for (const PluginInstance& p : host_.plugins) {
      if (p.vehicle != instance_.vehicle || p.sends.empty()) continue;
      senders.push_back({p.name, mavlink_topic(vehicle_, p), p.sends});
    }
    return senders;
  }

  Publisher<FigureSample> figure(const std::string& name, const std::string& unit,
                                 FigureKind kind) override {
    return host_.figures.add(around_.bus, {.vehicle = vehicle_.name,
                                           .plugin = instance_.name,
                                           .name = name,
                                           .unit = unit,
                                           .kind = kind});
  }

  /// The topic that mavlink() gave, if it did.
  const std::optional<Publisher<MavlinkMessage>>& sent() const { return sent_; }

 private:
  const PluginSurroundings& around_;
  const PluginInstance& instance_;
  const VehicleConfig& vehicle_;
  std::uint64_t seed_;
  Host host_;
  std::optional<Publisher<MavlinkMessage>> sent_;
};

}  // namespace

void PluginHost::load(VehicleId id, const VehicleConfig& vehicle) {
  for (const PluginConfig& config : vehicle.plugins) {
    const int number = base::sensor_number(config.params, config.plugin);
    const std::string name = base::sensor_name(config.plugin, number) + "@" + vehicle.name;
    const auto same = std::count_if(plugins_.begin(), plugins_.end(), [&](const PluginInstance& p) {
      return p.label.substr(0, p.label.find('#')) == name;
    });
    const std::string label = same == 0 ? name : name + "#" + std::to_string(same + 1);
    try {
      // The label's own part, so that twins draw different numbers and send on topics of their own.
      std::string own = label;
      own.erase(own.find('@'), vehicle.name.size() + 1);
      plugins_.push_back({.label = label,
                          .vehicle = id,
                          .plugin = loader_.create(config.plugin),
                          .name = std::move(own),
                          .sends = loader_.sends(config.plugin)});
    } catch (const base::ConfigError& error) {
      if (const auto key = config.params.find("plugin")) key->fail(error.what());
      throw;
    }
  }
}

std::vector<std::string> PluginHost::configure(const std::vector<VehicleConfig>& vehicles,
                                               const PluginSurroundings& around) {
  std::vector<std::pair<std::string, Publisher<MavlinkMessage>>> senders;
  std::size_t next = 0;
  for (const VehicleConfig& vehicle : vehicles) {
    for (const PluginConfig& config : vehicle.plugins) {
      const PluginInstance& instance = plugins_[next++];
      const auto seed =
          base::derive_seed(base::derive_seed(around.seed, vehicle.name), instance.name);
      Context context(around, instance, vehicle, seed, {plugins_, peers_, figures_});
      try {
        config.params.find("plugin");
        config.params.find("number");
        instance.plugin->configure(context, config.params);
        config.params.reject_unused();
        if (context.sent()) senders.emplace_back(instance.label, *context.sent());
      } catch (const base::CommandPortError& error) {
        throw base::CommandPortError("plugin " + instance.label + ": " + error.what());
      } catch (const base::DiskError& error) {
        throw base::DiskError("plugin " + instance.label + ": " + error.what());
      } catch (const base::ConfigError& error) {
        throw base::ConfigError("plugin " + instance.label + ": " + error.what());
      } catch (const std::exception& error) {
        config.params.fail("plugin " + instance.label + ": configure failed: " + error.what());
      } catch (...) {
        config.params.fail("plugin " + instance.label +
                           ": configure failed with an unknown exception");
      }
    }
  }
  std::vector<std::string> unsent;
  for (const auto& [label, sender] : senders) {
    if (!sender.has_subscribers()) unsent.push_back(label);
  }
  return unsent;
}

}  // namespace cas::sim
