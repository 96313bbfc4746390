// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/frames.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/wind/wind_model.hpp"

namespace cas::sim {
namespace {

/// Moves the air around its vehicle; starts the gusts that topic `gust` asks for.
class WindPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    initial_ = WindModel(parse_wind_params(params), context.seed());
    model_ = initial_;
    gusts_ = context.bus().subscribe<GustCommand>(
        context.topic("gust"), [this](const GustCommand& gust) { model_.start(gust); },
        Need::kOptional);
  }

  void pre_step(const StepInfo& step, World& world) override {
    const Eigen::Vector3d v_N = base::swap_WN(world.state(vehicle_).v_WB);
    const double height = world.environment(vehicle_).height_above_ground_m;
    const Eigen::Vector3d wind_N =
        model_.advance_N(step.time, base::to_seconds(step.dt), height, v_N);
    world.set_wind_W(vehicle_, base::swap_WN(wind_N));
  }

  void reset() override { model_ = initial_; }

 private:
  VehicleId vehicle_{};
  WindModel initial_;
  WindModel model_;
  Subscription gusts_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::WindPlugin, "wind")
