// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <span>
#include <string>

#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/aero/aero_model.hpp"

namespace cas::sim {
namespace {

/// The air on wings and tail: turns the control surfaces by topic `motor_command`, and publishes
/// their deflections on `surface_deflections`; `surface_health` breaks their servos, and the wash
/// of propellers follows `rotor_speeds`. Its parameters are block `aero` of the vehicle file.
class AeroPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    const std::optional<base::AeroParams>& aero = context.vehicle().aero;
    if (!aero) params.fail("plugin aero needs block 'aero' in the vehicle file");
    model_ = std::make_unique<AeroModel>(*aero, context.vehicle().rotors);
    context.add_force_model(*model_);
    deflections_ =
        context.bus().advertise<SurfaceDeflections>(context.topic("surface_deflections"));
    command_ = context.bus().subscribe<MotorCommand>(
        context.topic("motor_command"),
        [this](const MotorCommand& command) { model_->take(command); });
    rotors_ = context.vehicle().rotor_count();
    if (model_->has_wash()) {
      speeds_ = context.bus().subscribe<RotorSpeeds>(
          context.topic("rotor_speeds"),
          [this](const RotorSpeeds& speeds) { model_->set_rotor_speeds(speeds.omega_rad_s); });
    }
    health_ = context.bus().subscribe<SurfaceHealth>(
        context.topic(std::string(kSurfaceHealth)),
        [this](const SurfaceHealth& health) { model_->set_health(health); }, Need::kOptional);
  }

  void post_step(const StepInfo& step, const World& world) override {
    const std::span<const double> angles = world.states_of(*model_);
    deflections_.publish(
        {step.time, ActuatorValues::Map(angles.data(), static_cast<Eigen::Index>(angles.size()))});
  }

  void reset() override {
    model_->set_rotor_speeds(base::RotorVector::Zero(rotors_));
    model_->release();
    model_->set_health({});
  }

 private:
  std::unique_ptr<AeroModel> model_;
  Publisher<SurfaceDeflections> deflections_;
  int rotors_ = 0;
  Subscription command_;
  Subscription speeds_;
  Subscription health_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::AeroPlugin, "aero")
