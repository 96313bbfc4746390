// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/common/own_sensor_name.hpp"
#include "plugins/magnetometer/magnetometer_model.hpp"

namespace cas::sim {
namespace {

/// Publishes the magnetic field in B on topic `magnetometer`.
class MagnetometerPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& node) override {
    vehicle_ = context.vehicle_id();
    const auto params =
        read_at_rate<base::read_magnetometer_sheet>(node, base::to_seconds(context.step()));
    initial_ =
        MagnetometerModel(params, context.projection(), context.decimal_year(), context.seed());
    model_ = initial_;
    rate_ = base::RateGate(params.rate_hz);
    field_ = context.bus().advertise<MagnetometerSample>(
        context.topic(own_sensor_name("magnetometer", node)));
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (!rate_.due(step.time)) return;
    field_.publish(model_.sample(step.time, world.state(vehicle_), world.magnetic_field_W()));
  }

  void reset() override {
    model_ = initial_;
    rate_.reset();
  }

 private:
  VehicleId vehicle_{};
  MagnetometerModel initial_;
  MagnetometerModel model_;
  base::RateGate rate_;
  Publisher<MagnetometerSample> field_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::MagnetometerPlugin, "magnetometer")
