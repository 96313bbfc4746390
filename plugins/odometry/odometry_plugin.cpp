// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>

#include "base/earth/frames.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/odometry_sample.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/delay_line.hpp"
#include "plugins/odometry/odometry_messages.hpp"
#include "plugins/odometry/odometry_model.hpp"

namespace cas::sim {
namespace {

/// Publishes odometry on topic `odometry`, `delay_s` after it was measured, and sends what plugin
/// fault leaves of it as ODOMETRY or VISION_POSITION_ESTIMATE.
class OdometryPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    const OdometryParams odometry = parse_odometry_params(params, base::to_seconds(context.step()));
    model_ = OdometryModel(odometry, seed_);
    rate_ = base::RateGate(odometry.rate_hz);
    const double in_flight = base::to_seconds(odometry.delay) * odometry.rate_hz;
    delay_ = DelayLine<OdometrySample>(odometry.delay, static_cast<std::size_t>(in_flight) + 2);
    mavlink_ = context.mavlink();
    odometry_ = context.bus().advertise<OdometrySample>(context.topic("odometry"));
    sent_ = context.bus().subscribe<OdometrySample>(
        context.topic("odometry"), [this](const OdometrySample& sample) { send(sample); });
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (rate_.due(step.time)) delay_.push(step.time, measure(step.time, world.state(vehicle_)));
    while (const auto sample = delay_.pop(step.time)) odometry_.publish(*sample);
  }

  void reset() override {
    model_ = OdometryModel(model_.params(), seed_);
    rate_.reset();
    delay_.clear();
  }

 private:
  OdometrySample measure(base::SimTime time, const BodyState& state) {
    const Eigen::Vector3d& r_B = model_.params().position_B_m;
    const Eigen::Vector3d v_B = state.q_WB.conjugate() * state.v_WB + state.w_WB_B.cross(r_B);
    return model_.sample(time, {.p_N = base::swap_WN(state.p_WB + state.q_WB * r_B),
                                .q_ND = base::q_ND_from_q_WB(state.q_WB),
                                .v_D = base::swap_BD(v_B),
                                .w_D = base::swap_BD(state.w_WB_B)});
  }

  void send(const OdometrySample& sample) {
    const OdometryParams& params = model_.params();
    if (params.message == base::OdometryMessage::kOdometry) {
      mavlink_.publish(mavlink_message(to_odometry(sample, params)));
    } else {
      mavlink_.publish(mavlink_message(to_vision_position_estimate(sample, params)));
    }
  }

  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  OdometryModel model_;
  base::RateGate rate_;
  DelayLine<OdometrySample> delay_;
  Publisher<OdometrySample> odometry_;
  Subscription sent_;
  Publisher<MavlinkMessage> mavlink_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::OdometryPlugin, "odometry")
CAS_PLUGIN_SENDS("ODOMETRY", "VISION_POSITION_ESTIMATE")
