// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "base/earth/frames.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "mavlink/common/hil_optical_flow.hpp"
#include "plugins/optical_flow/optical_flow_model.hpp"

namespace cas::sim {
namespace {

using mavlink::common::HilOpticalFlow;

/// The wire's form: rad, microseconds, metres.
HilOpticalFlow to_hil_optical_flow(const FlowSample& sample) {
  constexpr double kMicroseconds = 1e6;
  HilOpticalFlow packet;
  packet.time_usec = base::to_time_usec(sample.time);
  packet.integration_time_us =
      static_cast<std::uint32_t>(std::llround(sample.time_s * kMicroseconds));
  packet.integrated_x = static_cast<float>(sample.flow_rad.x());
  packet.integrated_y = static_cast<float>(sample.flow_rad.y());
  packet.integrated_xgyro = static_cast<float>(sample.turn_rad.x());
  packet.integrated_ygyro = static_cast<float>(sample.turn_rad.y());
  packet.integrated_zgyro = static_cast<float>(sample.turn_rad.z());
  packet.quality = sample.quality;
  packet.distance = sample.distance_m ? static_cast<float>(*sample.distance_m) : -1.0F;
  return packet;
}

/// Publishes the samples of a camera that looks down on topic `optical_flow`, and sends as
/// HIL_OPTICAL_FLOW what plugin fault leaves of them.
class OpticalFlowPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    model_ = OpticalFlowModel(parse_optical_flow_params(params, base::to_seconds(context.step())),
                              seed_);
    rate_ = base::RateGate(model_.params().rate_hz);
    mavlink_ = context.mavlink();
    flow_ = context.bus().advertise<FlowSample>(context.topic("optical_flow"));
    sent_ = context.bus().subscribe<FlowSample>(
        context.topic("optical_flow"), [this](const FlowSample& sample) {
          mavlink_.publish(mavlink_message(to_hil_optical_flow(sample)));
        });
  }

  void post_step(const StepInfo& step, const World& world) override {
    const BodyState& state = world.state(vehicle_);
    const OpticalFlowParams& params = model_.params();
    const Eigen::Vector3d origin_W = state.p_WB + state.q_WB * params.position_B_m;
    const Eigen::Vector3d down_W = state.q_WB * -Eigen::Vector3d::UnitZ();
    const auto distance = world.ray_distance(vehicle_, origin_W, down_W, params.max_m);
    const Eigen::Vector3d v_B =
        state.q_WB.conjugate() * state.v_WB + state.w_WB_B.cross(params.position_B_m);
    model_.accumulate(base::swap_BD(v_B), base::swap_BD(state.w_WB_B), distance,
                      base::to_seconds(step.dt));
    if (!rate_.due(step.time)) return;
    FlowSample sample = model_.sample();
    sample.time = step.time;
    flow_.publish(sample);
  }

  void reset() override {
    model_ = OpticalFlowModel(model_.params(), seed_);
    rate_.reset();
  }

 private:
  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  OpticalFlowModel model_;
  base::RateGate rate_;
  Publisher<FlowSample> flow_;
  Subscription sent_;
  Publisher<MavlinkMessage> mavlink_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::OpticalFlowPlugin, "optical_flow")
CAS_PLUGIN_SENDS("HIL_OPTICAL_FLOW")
