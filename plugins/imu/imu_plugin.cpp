// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/own_sensor_name.hpp"
#include "plugins/imu/imu_model.hpp"

namespace cas::sim {
namespace {

/// Publishes specific force and angular rate on topic `imu`.
class ImuPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    model_ = ImuModel(parse_imu_params(params, base::to_seconds(context.step())), seed_);
    rate_ = base::RateGate(model_.params().rate_hz);
    imu_ = context.bus().advertise<ImuSample>(context.topic(own_sensor_name("imu", params)));
    if (model_.params().vibration_reference_rad_s > 0) {
      rotors_ = context.bus().subscribe<RotorSpeeds>(
          context.topic("rotor_speeds"),
          [this](const RotorSpeeds& speeds) { omega_ = speeds.omega_rad_s; });
    }
  }

  void post_step(const StepInfo& step, const World& world) override {
    const BodyState& state = world.state(vehicle_);
    const double dt = base::to_seconds(step.dt);
    model_.accumulate(state, world.environment(vehicle_).gravity_W, dt);
    model_.advance_vibration(omega_, dt);
    if (rate_.due(step.time)) imu_.publish(model_.sample(step.time, state));
  }

  void reset() override {
    model_ = ImuModel(model_.params(), seed_);
    rate_.reset();
    omega_.resize(0);
  }

 private:
  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  ImuModel model_;
  base::RateGate rate_;
  base::RotorVector omega_;
  Publisher<ImuSample> imu_;
  Subscription rotors_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::ImuPlugin, "imu")
