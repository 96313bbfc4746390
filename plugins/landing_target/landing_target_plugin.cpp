// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

#include "base/time/rate_gate.hpp"
#include "libsim/api/beacon_source.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "mavlink/common/landing_target.hpp"
#include "plugins/common/delay_line.hpp"
#include "plugins/landing_target/landing_target_model.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;

/// The wire's form. Without a measured distance it is 0, which receivers take for unknown.
mv::LandingTarget to_landing_target(const LandingTargetSample& sample) {
  mv::LandingTarget packet;
  packet.time_usec = base::to_time_usec(sample.time);
  packet.frame = mv::MavFrame::kBodyFrd;
  packet.angle_x = static_cast<float>(sample.angles_rad.x());
  packet.angle_y = static_cast<float>(sample.angles_rad.y());
  packet.distance = static_cast<float>(sample.distance_m.value_or(0));
  packet.type = mv::LandingTargetType::kLightBeacon;
  return packet;
}

/// Publishes each picture of a camera on topic `landing_target`, and sends those with the beacon as
/// LANDING_TARGET.
class LandingTargetPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    restart(parse_landing_target_params(params, base::to_seconds(context.step())));
    hear_beacon(context, params.at("beacon"));
    mavlink_ = context.mavlink();
    pictures_ = context.bus().advertise<LandingTargetSample>(context.topic("landing_target"));
    sent_ = context.bus().subscribe<LandingTargetSample>(
        context.topic("landing_target"), [this](const LandingTargetSample& sample) {
          if (sample.seen) mavlink_.publish(mavlink_message(to_landing_target(sample)));
        });
    off_ = context.figure("distance from the beacon", "m");
    seen_share_ = context.figure("pictures with the beacon", "%", FigureKind::kScalar);
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (rate_.due(step.time)) look(step.time, world);
    while (const auto sample = delay_.pop(step.time)) pictures_.publish(*sample);
  }

  void reset() override { restart(model_.params()); }

  std::string stats_json() const override {
    return fmt::format(R"({{"pictures":{},"seen":{},"hidden":{}}})", count_, seen_, hidden_);
  }

 private:
  void hear_beacon(PluginContext& context, const base::ConfigNode& key) {
    const std::string topic = BeaconSource::topic(key.as<std::string>());
    if (!context.bus().is_advertised(topic)) {
      key.fail("the world has no beacon of this name: its list `beacons` gives them");
    }
    beacon_ = context.bus().subscribe<BeaconSource>(
        topic, [this](const BeaconSource& source) { place_W_ = source.place_W; });
  }

  void restart(const LandingTargetParams& params) {
    model_ = LandingTargetModel(params, seed_);
    rate_ = base::RateGate(params.rate_hz);
    const double waiting = base::to_seconds(params.delay) * params.rate_hz;
    delay_ = {params.delay, static_cast<std::size_t>(std::ceil(waiting)) + 2};
    count_ = seen_ = hidden_ = 0;
  }

  void look(base::SimTime time, const World& world) {
    const BodyState& vehicle = world.state(vehicle_);
    const Eigen::Vector3d beacon_W = place_W_(time);
    const Eigen::Vector3d p_S = model_.from_eye_S(vehicle, beacon_W);
    const bool in_view = model_.in_view(p_S);
    const bool hidden = in_view && is_hidden(world, model_.eye_W(vehicle), beacon_W);
    const LandingTargetSample sample = model_.sample(time, p_S, in_view && !hidden);
    delay_.push(time, sample);
    ++count_;
    hidden_ += hidden ? 1 : 0;
    seen_ += sample.seen ? 1 : 0;
    off_.publish({time, (beacon_W - vehicle.p_WB).head<2>().norm()});
    constexpr double kPercent = 100;
    seen_share_.publish(
        {time, kPercent * static_cast<double>(seen_) / static_cast<double>(count_)});
  }

  /// The surface under the beacon does not hide it.
  bool is_hidden(const World& world, const Eigen::Vector3d& eye_W,
                 const Eigen::Vector3d& beacon_W) const {
    constexpr double kBeside_m = 0.05;
    const Eigen::Vector3d way_W = beacon_W - eye_W;
    const double range_m = way_W.norm() - kBeside_m;
    return range_m > 0 && world.ray_distance(vehicle_, eye_W, way_W, range_m).has_value();
  }

  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  LandingTargetModel model_;
  base::RateGate rate_;
  DelayLine<LandingTargetSample> delay_;
  std::function<Eigen::Vector3d(base::SimTime)> place_W_;
  std::uint64_t count_ = 0;
  std::uint64_t seen_ = 0;
  std::uint64_t hidden_ = 0;
  Subscription beacon_;
  Publisher<LandingTargetSample> pictures_;
  Subscription sent_;
  Publisher<MavlinkMessage> mavlink_;
  Publisher<FigureSample> off_, seen_share_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::LandingTargetPlugin, "landing_target")
CAS_PLUGIN_SENDS("LANDING_TARGET")
