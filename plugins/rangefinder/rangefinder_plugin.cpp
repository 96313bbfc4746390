// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/own_sensor_name.hpp"
#include "plugins/rangefinder/rangefinder_model.hpp"

namespace cas::sim {
namespace {

/// Publishes the distance to the first surface along a ray on topic `rangefinder`.
class RangefinderPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    model_ =
        RangefinderModel(parse_rangefinder_params(params, base::to_seconds(context.step())), seed_);
    rate_ = base::RateGate(model_.params().rate_hz);
    range_ =
        context.bus().advertise<RangeSample>(context.topic(own_sensor_name("rangefinder", params)));
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (!rate_.due(step.time)) return;
    const BodyState& state = world.state(vehicle_);
    const RangefinderParams& params = model_.params();
    const Eigen::Vector3d origin_W = state.p_WB + state.q_WB * params.position_B_m;
    const Eigen::Vector3d direction_W = state.q_WB * params.direction_B;
    const auto distance = world.ray_distance(vehicle_, origin_W, direction_W, params.max_m);
    range_.publish(model_.sample(step.time, distance));
  }

  void reset() override {
    model_ = RangefinderModel(model_.params(), seed_);
    rate_.reset();
  }

 private:
  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  RangefinderModel model_;
  base::RateGate rate_;
  Publisher<RangeSample> range_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::RangefinderPlugin, "rangefinder")
CAS_PLUGIN_SENDS("DISTANCE_SENSOR")  // which mavlink_interface makes of the topic
