// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/motor/motor_mixer.hpp"
#include "plugins/motor/rotor_model.hpp"

namespace cas::sim {
namespace {

/// Drives the rotors from topic `motor_command`; publishes their speeds on `rotor_speeds`.
class MotorPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode&) override {
    mixer_ = MotorMixer(context.vehicle());
    rotors_ = std::make_unique<RotorModel>(context.vehicle());
    context.add_force_model(*rotors_);
    speeds_ = context.bus().advertise<RotorSpeeds>(context.topic("rotor_speeds"));
    command_ = context.bus().subscribe<MotorCommand>(
        context.topic("motor_command"),
        [this](const MotorCommand& command) { rotors_->set_targets(mixer_.targets(command)); });
  }

  void post_step(const StepInfo& step, const World& world) override {
    speeds_.publish({step.time, Eigen::Vector4d(world.states_of(*rotors_).data())});
  }

  void reset() override { rotors_->set_targets(Eigen::Vector4d::Zero()); }

 private:
  MotorMixer mixer_;
  std::unique_ptr<RotorModel> rotors_;
  Publisher<RotorSpeeds> speeds_;
  Subscription command_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::MotorPlugin, "motor")
