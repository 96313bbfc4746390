// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/frames.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/delay_line.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/common/own_sensor_name.hpp"
#include "plugins/gps/gps_model.hpp"

namespace cas::sim {
namespace {

/// Publishes place and velocity on topic `gps`, `delay_s` after they were measured.
class GpsPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    projection_ = context.projection();
    seed_ = context.seed();
    const base::GpsSheet gps =
        read_at_rate<base::read_gps_sheet>(params, base::to_seconds(context.step()));
    model_ = GpsModel(gps, projection_, seed_);
    rate_ = base::RateGate(gps.rate_hz);
    const double in_flight = gps.delay_s * gps.rate_hz;
    delay_ = DelayLine<GpsSample>(base::from_seconds(gps.delay_s),
                                  static_cast<std::size_t>(in_flight) + 2);
    gps_ = context.bus().advertise<GpsSample>(context.topic(own_sensor_name("gps", params)));
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (rate_.due(step.time)) delay_.push(step.time, measure(step.time, world.state(vehicle_)));
    while (const auto sample = delay_.pop(step.time)) gps_.publish(*sample);
  }

  void reset() override {
    model_ = GpsModel(model_.sheet(), projection_, seed_);
    rate_.reset();
    delay_.clear();
  }

 private:
  GpsSample measure(base::SimTime time, const BodyState& state) {
    const Eigen::Vector3d& r_B = model_.sheet().antenna_B_m;
    const Eigen::Vector3d p_W = state.p_WB + state.q_WB * r_B;
    const Eigen::Vector3d v_W = state.v_WB + state.q_WB * state.w_WB_B.cross(r_B);
    return model_.sample(time, base::swap_WN(p_W), base::swap_WN(v_W));
  }

  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  base::LocalProjection projection_;
  GpsModel model_;
  base::RateGate rate_;
  DelayLine<GpsSample> delay_;
  Publisher<GpsSample> gps_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::GpsPlugin, "gps")
