// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dlfcn.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/config/vehicle.hpp"
#include "libsim/api/plugin.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

inline const base::Geodetic kHome{47.397742, 8.545594, 488.0};
inline constexpr double kGravity = 9.80665;

inline base::Vehicle load_vehicle(const std::string& name) {
  return base::Vehicle::load(std::filesystem::path(cas::test::source_dir()) / "config/vehicles" /
                             (name + ".yaml"));
}

/// A world of one vehicle whose state the test writes. Force models keep the states they are given.
class ScriptedWorld final : public sim::World {
 public:
  ScriptedWorld() {
    air.gravity_W = {0, 0, -kGravity};
    air.air_density_kg_m3 = 1.225;
    air.height_above_ground_m = 100;
  }

  const sim::BodyState& state(sim::VehicleId) const override { return body; }
  std::span<const double> states_of(const sim::ForceModel& model) const override {
    return model_states.at(&model);
  }
  const sim::Environment& environment(sim::VehicleId) const override { return air; }
  double mass_kg(sim::VehicleId) const override { return 1.55 * mass_factor; }
  bool in_contact(sim::VehicleId) const override { return false; }
  const base::LocalProjection& projection() const override { return projection_; }
  double decimal_year() const override { return 2026.5; }
  std::optional<double> ray_distance(sim::VehicleId, const Eigen::Vector3d& origin_W,
                                     const Eigen::Vector3d& direction_W,
                                     double range_m) const override {
    if (direction_W.z() >= 0) return std::nullopt;  // the ground is the plane z = 0
    const double distance = -origin_W.z() / direction_W.normalized().z();
    if (distance < 0 || distance > range_m) return std::nullopt;
    return distance;
  }
  void set_wind_W(sim::VehicleId, const Eigen::Vector3d& wind_W) override { air.wind_W = wind_W; }
  void set_wind_gradient_W(sim::VehicleId, const Eigen::Matrix3d& gradient_W) override {
    air.wind_gradient_W = gradient_W;
  }
  void add_wrench(sim::VehicleId, const sim::Wrench& wrench) override {
    added.force_B += wrench.force_B;
    added.torque_B += wrench.torque_B;
  }
  void scale_mass(sim::VehicleId, double factor) override { mass_factor = factor; }
  bool disc_touches(sim::VehicleId, const Eigen::Vector3d& centre_B, const Eigen::Vector3d& axis_B,
                    double) const override {
    return touched_disc_B && centre_B == *touched_disc_B && axis_B.isApprox(disc_axis_B);
  }

  sim::BodyState body;
  sim::Environment air;
  sim::Wrench added;
  double mass_factor = 1.0;
  std::optional<Eigen::Vector3d> touched_disc_B;  // centre of the one that touches something
  Eigen::Vector3d disc_axis_B = Eigen::Vector3d::UnitZ();  // and its axis
  std::map<const sim::ForceModel*, std::vector<double>> model_states;

 private:
  base::LocalProjection projection_{kHome};
};

/// Argument of `configure` in tests.
class TestContext final : public sim::PluginContext {
 public:
  TestContext(sim::TopicBus& bus, ScriptedWorld& world, base::Vehicle vehicle, base::Duration step,
              std::filesystem::path output_dir)
      : bus_(bus),
        world_(world),
        vehicle_(std::move(vehicle)),
        step_(step),
        output_dir_(std::move(output_dir)) {}

  sim::TopicBus& bus() override { return bus_; }
  std::string topic(const std::string& name) const override { return "iris0/" + name; }
  sim::VehicleId vehicle_id() const override { return sim::VehicleId{0}; }
  const base::Vehicle& vehicle() const override { return vehicle_; }
  std::string vehicle_name() const override { return "iris0"; }
  std::uint64_t seed() const override { return 42; }
  base::Duration step() const override { return step_; }
  const base::LocalProjection& projection() const override { return world_.projection(); }
  double decimal_year() const override { return world_.decimal_year(); }
  std::filesystem::path output_dir() const override { return output_dir_; }
  void add_force_model(sim::ForceModel& model) override {
    force_models.push_back(&model);
    auto& states = world_.model_states[&model];
    states.resize(static_cast<std::size_t>(model.state_count()));
    model.initial_states(states);
  }
  void set_lockstep_peer(sim::LockstepPeer& peer) override { lockstep_peer = &peer; }

  std::vector<sim::ForceModel*> force_models;
  sim::LockstepPeer* lockstep_peer = nullptr;

 private:
  sim::TopicBus& bus_;
  ScriptedWorld& world_;
  base::Vehicle vehicle_;
  base::Duration step_;
  std::filesystem::path output_dir_;
};

inline base::Vehicle changed(base::Vehicle vehicle,
                             const std::function<void(base::Vehicle&)>& change) {
  change(vehicle);
  return vehicle;
}

/// Steps plugins of the build tree, loaded as libraries, against a ScriptedWorld.
class PluginHarness {
 public:
  explicit PluginHarness(
      base::Duration step = std::chrono::milliseconds(1), std::filesystem::path output_dir = ".",
      const std::string& vehicle = "iris_px4",
      const std::function<void(base::Vehicle&)>& change = [](auto&) {})
      : context(bus, world, changed(load_vehicle(vehicle), change), step, std::move(output_dir)),
        step_(step) {}

  /// Loads lib<name>.so and configures it with a YAML text.
  sim::Plugin& add(const std::string& name, const std::string& yaml) {
    const std::string file = cas::test::binary_dir() + "/plugins/lib" + name + ".so";
    void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) throw std::runtime_error(dlerror());
    const auto entry =
        reinterpret_cast<const sim::PluginDescriptor* (*)()>(dlsym(library, "cas_plugin_v1"));
    const sim::PluginDescriptor* descriptor = entry();
    plugins_.push_back({descriptor->create(), descriptor->destroy});
    const base::ConfigNode node = base::ConfigNode::parse(yaml);
    plugins_.back()->configure(context, node);
    node.reject_unused();
    return *plugins_.back();
  }

  void step() {
    const base::SimTime start(step_ * static_cast<base::Duration::rep>(index_));
    for (const auto& plugin : plugins_) plugin->pre_step({start, step_, index_}, world);
    for (const auto& plugin : plugins_) plugin->post_step({start + step_, step_, index_}, world);
    ++index_;
  }
  void run(base::Duration time) {
    for (base::Duration done{}; done < time; done += step_) step();
  }
  void reset() {
    for (const auto& plugin : plugins_) plugin->reset();
    index_ = 0;
  }
  void finish() {
    for (const auto& plugin : plugins_) plugin->finish();
  }

  sim::TopicBus bus;
  ScriptedWorld world;
  TestContext context;

 private:
  using PluginPtr = std::unique_ptr<sim::Plugin, void (*)(sim::Plugin*)>;

  base::Duration step_;
  std::uint64_t index_ = 0;
  std::vector<PluginPtr> plugins_;
};

/// The samples of one topic of the vehicle, from now on.
template <class Sample>
struct Heard {
  Heard(PluginHarness& harness, const std::string& topic)
      : listening(harness.bus.subscribe<Sample>("iris0/" + topic, [this](const Sample& sample) {
          newest = sample;
          all.push_back(sample);
        })) {}
  Heard(const Heard&) = delete;
  Heard& operator=(const Heard&) = delete;

  Sample newest{};
  std::vector<Sample> all;
  sim::Subscription listening;
};

}  // namespace cas::test
