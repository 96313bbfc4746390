// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <optional>
#include <string>

#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/motor/battery_model.hpp"
#include "plugins/motor/body_drag.hpp"
#include "plugins/motor/motor_mixer.hpp"
#include "plugins/motor/rotor_model.hpp"

namespace cas::sim {
namespace {

/// The vehicle's forces of propulsion and air: drives the rotors from topic `motor_command`;
/// publishes their speeds on `rotor_speeds`. Topic `propulsion_health` takes away what is broken.
class MotorPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode&) override {
    const base::Vehicle& vehicle = context.vehicle();
    mixer_ = MotorMixer(vehicle);
    rotors_ = std::make_unique<RotorModel>(vehicle);
    if (vehicle.battery) full_battery_.emplace(*vehicle.battery, vehicle.rotor.torque_coefficient);
    battery_ = full_battery_;
    context.add_force_model(*rotors_);
    if (vehicle.body_drag_linear_n_s_m > 0) {
      drag_.emplace(vehicle.body_drag_linear_n_s_m);
      context.add_force_model(*drag_);
    }
    speeds_ = context.bus().advertise<RotorSpeeds>(context.topic("rotor_speeds"));
    command_ = context.bus().subscribe<MotorCommand>(context.topic("motor_command"),
                                                     [this](const MotorCommand& command) {
                                                       asked_ = mixer_.targets(command);
                                                       drive();
                                                     });
    health_topic_ = context.bus().subscribe<PropulsionHealth>(
        context.topic("propulsion_health"),
        [this](const PropulsionHealth& health) {
          health_ = health;
          rotors_->set_effectiveness(health.thrust_share);
          drive();
        },
        Need::kOptional);
  }

  void post_step(const StepInfo& step, const World& world) override {
    const Eigen::Vector4d omega(world.states_of(*rotors_).data());
    speeds_.publish({step.time, omega});
    if (!battery_) return;
    battery_->advance(omega, base::to_seconds(step.dt));
    drive();
  }

  void reset() override {
    battery_ = full_battery_;
    health_ = {};
    asked_.setZero();
    rotors_->set_effectiveness(health_.thrust_share);
    drive();
  }

  std::string stats_json() const override {
    if (!battery_) return {};
    return "{\"battery_v\":" + std::to_string(battery_->voltage_v()) +
           ",\"battery_charge\":" + std::to_string(battery_->charge()) + "}";
  }

 private:
  /// Passes on the speeds that battery and rotors can follow.
  void drive() {
    const double voltage_share = health_.voltage_share * (battery_ ? battery_->speed_share() : 1.0);
    rotors_->set_targets(voltage_share * asked_.cwiseProduct(health_.speed_share));
  }

  MotorMixer mixer_;
  std::unique_ptr<RotorModel> rotors_;
  std::optional<BodyDrag> drag_;
  std::optional<BatteryModel> full_battery_;
  std::optional<BatteryModel> battery_;
  PropulsionHealth health_;
  Eigen::Vector4d asked_ = Eigen::Vector4d::Zero();
  Publisher<RotorSpeeds> speeds_;
  Subscription command_;
  Subscription health_topic_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::MotorPlugin, "motor")
