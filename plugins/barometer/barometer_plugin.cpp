// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/frames.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/barometer/barometer_model.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/common/own_sensor_name.hpp"

namespace cas::sim {
namespace {

/// Publishes pressure and temperature on topic `barometer`.
class BarometerPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    projection_ = context.projection();
    seed_ = context.seed();
    model_ = BarometerModel(
        read_at_rate<base::read_barometer_sheet>(params, base::to_seconds(context.step())), seed_);
    rate_ = base::RateGate(model_.sheet().rate_hz);
    pressure_ = context.bus().advertise<BarometerSample>(
        context.topic(own_sensor_name("barometer", params)));
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (!rate_.due(step.time)) return;
    const BodyState& state = world.state(vehicle_);
    const Environment& air = world.environment(vehicle_);
    const double alt_m = projection_.to_geodetic(base::swap_WN(state.p_WB)).alt_m;
    const double airspeed = (state.v_WB - air.wind_W).norm();
    pressure_.publish(
        model_.sample(step.time, alt_m, airspeed, air.air_density_kg_m3, world.atmosphere()));
  }

  void reset() override {
    model_ = BarometerModel(model_.sheet(), seed_);
    rate_.reset();
  }

 private:
  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  base::LocalProjection projection_;
  BarometerModel model_;
  base::RateGate rate_;
  Publisher<BarometerSample> pressure_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::BarometerPlugin, "barometer")
