// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/airspeed/airspeed_model.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

/// Publishes the differential pressure of a pitot tube on topic `airspeed`.
class AirspeedPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    step_s_ = base::to_seconds(context.step());
    model_ =
        AirspeedModel(read_at_rate<base::read_airspeed_sheet>(params, step_s_), step_s_, seed_);
    rate_ = base::RateGate(model_.sheet().rate_hz);
    pressure_ = context.bus().advertise<AirspeedSample>(context.topic("airspeed"));
  }

  void post_step(const StepInfo& step, const World& world) override {
    const Environment& air = world.environment(vehicle_);
    model_.follow(speed_along_tube(world.state(vehicle_), air.wind_W, model_.sheet()),
                  air.air_density_kg_m3);
    if (rate_.due(step.time)) pressure_.publish(model_.sample(step.time));
  }

  void reset() override {
    model_ = AirspeedModel(model_.sheet(), step_s_, seed_);
    rate_.reset();
  }

 private:
  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  double step_s_ = 0;
  AirspeedModel model_;
  base::RateGate rate_;
  Publisher<AirspeedSample> pressure_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::AirspeedPlugin, "airspeed")
