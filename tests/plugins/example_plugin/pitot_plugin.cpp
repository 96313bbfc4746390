// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/rate_gate.hpp"
#include "libsim/api/plugin.hpp"
#include "pitot_model.hpp"

namespace pitot {
namespace {

using namespace cas;

/// Publishes the pressure in a pitot tube on topic `airspeed`.
class PitotPlugin final : public sim::Plugin {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    stddev_pa_ = params.require_in("stddev_pa", 0, 1000);
    rate_ = base::RateGate(params.require_in("rate_hz", 0.001, 1000));
    model_ = PitotModel(stddev_pa_, seed_);
    airspeed_ = context.bus().advertise<AirspeedSample>(context.topic("airspeed"));
  }

  void post_step(const sim::StepInfo& step, const sim::World& world) override {
    if (!rate_.due(step.time)) return;
    const sim::BodyState& body = world.state(vehicle_);
    const sim::Environment& air = world.environment(vehicle_);
    airspeed_.publish(
        model_.sample(step.time, body.q_WB, body.v_WB - air.wind_W, air.air_density_kg_m3));
    ++samples_;
  }

  void reset() override {
    model_ = PitotModel(stddev_pa_, seed_);
    rate_.reset();
    samples_ = 0;
  }

  std::string stats_json() const override {
    return "{\"samples\":" + std::to_string(samples_) + "}";
  }

 private:
  sim::VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  double stddev_pa_ = 0;
  PitotModel model_;
  base::RateGate rate_;
  std::uint64_t samples_ = 0;
  sim::Publisher<AirspeedSample> airspeed_;
};

}  // namespace
}  // namespace pitot

CAS_PLUGIN(pitot::PitotPlugin, "pitot")
