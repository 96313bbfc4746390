// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/rounding.hpp"
#include "plugins/motor/battery_model.hpp"
#include "plugins/motor/body_drag.hpp"
#include "plugins/motor/esc_delay.hpp"
#include "plugins/motor/motor_mixer.hpp"
#include "plugins/motor/rotor_model.hpp"

namespace cas::sim {
namespace {

/// Below this speed a rotor that was switched off counts as stopped: its speed decays and is never
/// quite 0.
constexpr double kTurning_rad_s = 1.0;
/// Samples of the battery: often enough for a failsafe, and little on a serial line.
constexpr double kBattery_hz = 2.0;
/// Telemetry of the speed controllers, as often as autopilots stream it.
constexpr double kEsc_hz = 10.0;
/// As many values as a figure keeps.
constexpr double kFigures_hz = 50.0;

/// The vehicle's forces of propulsion and air: drives the rotors from topic `motor_command`;
/// publishes their speeds on `rotor_speeds`, the battery, if any, on `battery` and the telemetry of
/// motors with a circuit on `esc`. Topic
/// `propulsion_health` weakens broken parts.
class MotorPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode&) override {
    const base::Vehicle& vehicle = context.vehicle();
    vehicle_ = context.vehicle_id();
    name_ = context.vehicle_name();
    discs_ = vehicle.rotors;
    strikes_.reserve(discs_.size());
    asked_.setZero(vehicle.rotor_count());
    driven_ = asked_;
    mixer_ = MotorMixer(vehicle);
    esc_ = EscDelay(vehicle, context.step());
    require_lags(vehicle, base::to_seconds(context.step()));
    rotors_ = std::make_unique<RotorModel>(vehicle);
    if (vehicle.battery) {
      if (!rotors_->has_circuit()) full_battery_.emplace(*vehicle.battery);
      measured_ = context.bus().advertise<BatterySample>(context.topic("battery"));
    }
    if (rotors_->has_circuit()) {
      esc_telemetry_ = context.bus().advertise<EscSample>(context.topic("esc"));
      for (int i = 1; i <= vehicle.rotor_count(); ++i) {
        motor_currents_.push_back(context.figure(fmt::format("current of motor {}", i), "A"));
      }
    }
    battery_ = full_battery_;
    context.add_force_model(*rotors_);
    if (vehicle.body_drag_linear_n_s_m > 0 || vehicle.body_drag) {
      drag_.emplace(vehicle.body_drag_linear_n_s_m, vehicle.body_drag);
      context.add_force_model(*drag_);
    }
    speeds_ = context.bus().advertise<RotorSpeeds>(context.topic("rotor_speeds"));
    command_ = context.bus().subscribe<MotorCommand>(context.topic("motor_command"),
                                                     [this](const MotorCommand& command) {
                                                       look_for_reverse(command);
                                                       take(mixer_.targets(command));
                                                       tilt(command);
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
    const std::span<const double> states = world.states_of(*rotors_);
    const base::RotorVector omega = base::RotorVector::Map(states.data(), rotors_->rotor_count());
    speeds_.publish({step.time, omega});
    look_for_strikes(step, world, states);
    now_ = step.time;
    if (esc_.is_used()) asked_ = esc_.held(now_);
    if (battery_) advance_battery(step, world, states);
    if (rotors_->has_circuit()) look_at_circuit(step, states);
    if (battery_ || esc_.is_used()) drive();
  }

  void reset() override {
    battery_ = full_battery_;
    reading_ = {};
    battery_due_.reset();
    esc_due_.reset();
    figures_due_.reset();
    health_ = {};
    asked_.setZero();
    driven_.setZero();
    esc_.clear();
    now_ = {};
    rotors_->set_tilt_targets(asked_);
    strikes_.clear();
    refused_reverse_.reset();
    rotors_->release_all();
    rotors_->set_effectiveness(health_.thrust_share);
    drive();
  }

  std::string stats_json() const override {
    nlohmann::ordered_json figures;
    if (battery_ || rotors_->has_circuit()) {
      const BatteryReading last = battery_ ? battery_->reading() : reading_;
      figures["battery_v"] = six_decimals(last.voltage_v);
      figures["battery_charge"] = six_decimals(last.charge);
    }
    for (const Strike& strike : strikes_) {
      figures["rotor_strikes"].push_back(
          {{"rotor", strike.rotor + 1}, {"time_s", six_decimals(base::to_seconds(strike.time))}});
    }
    if (refused_reverse_) figures["warnings"].push_back(refusal());
    return figures.is_null() ? "" : figures.dump();
  }

 private:
  /// A lag far shorter than the step would swing the speed to and fro, step by step.
  static void require_lags(const base::Vehicle& vehicle, double step_s) {
    for (const base::Rotor& rotor : vehicle.rotors) {
      for (const double lag_s :
           {rotor.params.time_constant_up_s, rotor.params.time_constant_down_s}) {
        if (lag_s == 0 || lag_s >= 0.5 * step_s || rotor.electric) continue;
        throw base::ConfigError(fmt::format(
            "a rotor's time constant of {:g} s is shorter than half the step of {:g} s: give 0, "
            "which has no lag, or a smaller step_us",
            lag_s, step_s));
      }
    }
  }

  struct Strike {
    std::size_t rotor;
    base::SimTime time;
  };

  /// The measured voltage includes the loss caused by a fault.
  void advance_battery(const StepInfo& step, const World& world, std::span<const double> states) {
    const base::RotorVector powers_w =
        rotors_->shaft_powers(world.state(vehicle_), world.environment(vehicle_), states);
    battery_->advance(powers_w.sum(), base::to_seconds(step.dt));
    if (!battery_due_.due(step.time)) return;
    BatteryReading reading = battery_->reading();
    reading.voltage_v *= health_.voltage_share;
    publish(step.time, reading);
  }

  /// The circuits' battery was carried by the integrator.
  void look_at_circuit(const StepInfo& step, std::span<const double> states) {
    const MotorCircuit::Supply supply = rotors_->supply(states);
    reading_ = rotors_->battery(supply, states);
    if (battery_due_.due(step.time)) publish(step.time, reading_);
    if (esc_due_.due(step.time)) {
      EscSample sample{.time = step.time, .voltage_v = supply.voltage_v};
      sample.omega_rad_s = base::RotorVector::Map(states.data(), rotors_->rotor_count());
      sample.current_a = base::RotorVector::Map(supply.motor_a.data(), rotors_->rotor_count());
      esc_telemetry_.publish(sample);
    }
    if (!figures_due_.due(step.time)) return;
    for (std::size_t i = 0; i < motor_currents_.size(); ++i) {
      motor_currents_[i].publish({step.time, supply.motor_a[i]});
    }
  }

  void publish(base::SimTime time, const BatteryReading& reading) {
    measured_.publish({.time = time,
                       .voltage_v = reading.voltage_v,
                       .current_a = reading.current_a,
                       .used_ah = reading.used_ah,
                       .charge = reading.charge});
  }

  /// A turning rotor whose disc touches the world or another vehicle stops, and stays so.
  void look_for_strikes(const StepInfo& step, const World& world, std::span<const double> states) {
    std::size_t servo = discs_.size();  // its state
    for (std::size_t i = 0; i < discs_.size(); ++i) {
      const base::Rotor& disc = discs_[i];
      const double tilt_rad = disc.tilt ? states[servo++] : 0.0;
      if (rotors_->is_stopped(i) || std::abs(states[i]) < kTurning_rad_s) continue;
      const Eigen::Vector3d axis_B = disc.tilt ? disc.tilted_axis_B(tilt_rad) : disc.axis_B;
      if (!world.disc_touches(vehicle_, disc.position_B_m, axis_B, disc.params.radius_m)) continue;
      rotors_->stop(i);
      strikes_.push_back({i, step.time});
      base::log::warn(fmt::format("{}: rotor {} touched something at {:f} s and stopped", name_,
                                  i + 1, base::to_seconds(step.time)));
    }
  }

  /// Says once that a controller wants a rotor to turn the other way, and it does not.
  void look_for_reverse(const MotorCommand& command) {
    if (refused_reverse_) return;
    refused_reverse_ = mixer_.refused_reverse(command);
    if (!refused_reverse_) return;
    base::log::warn(refusal());
  }

  std::string refusal() const {
    return fmt::format(
        "{}: rotor {} was asked to turn the other way (an output below 0) and stayed at idle: the "
        "vehicle file does not say that it is `reversible`",
        name_, *refused_reverse_ + 1);
  }

  /// Speeds that the controller asks for from now on.
  void take(const base::RotorVector& asked) {
    if (esc_.is_used()) {
      esc_.push(now_, asked);
      asked_ = esc_.held(now_);
    } else {
      asked_ = asked;
    }
  }

  /// Passes on the speeds that battery and rotors can follow; circuits feel the voltage themselves.
  void drive() {
    double voltage_share = health_.voltage_share * (battery_ ? battery_->speed_share() : 1.0);
    if (rotors_->has_circuit()) {
      rotors_->set_voltage_share(health_.voltage_share);
      rotors_->cut_currents(health_.without_current);
      voltage_share = 1;
    }
    for (Eigen::Index i = 0; i < driven_.size(); ++i) {
      const auto rotor = static_cast<std::size_t>(i);
      if (health_.stuck[rotor]) continue;
      double own_share = i < health_.speed_share.size() ? health_.speed_share[i] : 1.0;
      if (health_.without_current[rotor] && !rotors_->has_circuit()) own_share = 0;
      driven_[i] = voltage_share * own_share * asked_[health_.wired_as[rotor]];
    }
    rotors_->set_targets(driven_);
  }

  void tilt(const MotorCommand& command) {
    if (mixer_.has_servos()) rotors_->set_tilt_targets(mixer_.tilts(command));
  }

  VehicleId vehicle_{};
  std::string name_;
  std::vector<base::Rotor> discs_;
  std::vector<Strike> strikes_;
  std::optional<int> refused_reverse_;  ///< index of the rotor
  MotorMixer mixer_;
  EscDelay esc_;
  base::SimTime now_;  // between steps
  std::unique_ptr<RotorModel> rotors_;
  std::optional<BodyDrag> drag_;
  std::optional<BatteryModel> full_battery_;
  std::optional<BatteryModel> battery_;
  BatteryReading reading_;  ///< of the circuits' battery
  base::RateGate battery_due_{kBattery_hz};
  base::RateGate esc_due_{kEsc_hz};
  base::RateGate figures_due_{kFigures_hz};
  PropulsionHealth health_;
  base::RotorVector asked_;
  base::RotorVector driven_;  ///< speeds that the rotors are to reach
  Publisher<RotorSpeeds> speeds_;
  Publisher<BatterySample> measured_;
  Publisher<EscSample> esc_telemetry_;
  std::vector<Publisher<FigureSample>> motor_currents_;
  Subscription command_;
  Subscription health_topic_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::MotorPlugin, "motor")
