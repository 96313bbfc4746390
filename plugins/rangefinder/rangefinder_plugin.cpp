// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/common/own_sensor_name.hpp"
#include "plugins/rangefinder/rangefinder_model.hpp"

namespace cas::sim {
namespace {

/// Publishes the distance to the nearest surface along a ray, or in a cone, on topic `rangefinder`.
class RangefinderPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    model_ = RangefinderModel(
        read_at_rate<base::read_rangefinder_sheet>(params, base::to_seconds(context.step())),
        seed_);
    rate_ = base::RateGate(model_.sheet().rate_hz);
    directions_B_ = beam_directions_B(model_.sheet());
    directions_W_.resize(directions_B_.size());
    origins_W_.resize(directions_B_.size());
    hits_.resize(directions_B_.size());
    if (hits_.size() > 1) context.expect_rays();
    range_ =
        context.bus().advertise<RangeSample>(context.topic(own_sensor_name("rangefinder", params)));
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (!rate_.due(step.time)) return;
    const BodyState& state = world.state(vehicle_);
    const base::RangefinderSheet& sheet = model_.sheet();
    std::ranges::fill(origins_W_, state.p_WB + state.q_WB * sheet.position_B_m);
    for (std::size_t i = 0; i < hits_.size(); ++i) directions_W_[i] = state.q_WB * directions_B_[i];
    world.cast(vehicle_, origins_W_, directions_W_, sheet.max_m, hits_);
    const double distance_m = std::ranges::min(hits_, {}, &RayHit::distance_m).distance_m;
    const bool is_met = std::isfinite(distance_m);
    range_.publish(model_.sample(step.time, is_met ? std::optional(distance_m) : std::nullopt));
  }

  void reset() override {
    model_ = RangefinderModel(model_.sheet(), seed_);
    rate_.reset();
  }

 private:
  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  RangefinderModel model_;
  std::vector<Eigen::Vector3d> directions_B_;
  std::vector<Eigen::Vector3d> directions_W_;
  std::vector<Eigen::Vector3d> origins_W_;
  std::vector<RayHit> hits_;
  base::RateGate rate_;
  Publisher<RangeSample> range_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::RangefinderPlugin, "rangefinder")
CAS_PLUGIN_SENDS("DISTANCE_SENSOR")  // which mavlink_interface makes of the topic
