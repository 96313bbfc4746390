// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "base/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "mavlink/common/battery_status.hpp"

namespace {

using namespace cas;
using mavlink::common::BatteryStatus;

/// The rotors' power drains it; its voltage falls with charge and load.
class BatteryPlugin final : public sim::Plugin {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode& params) override {
    // What the scenario says.
    full_v_ = params.require_in("full_v", 5, 60);
    empty_v_ = params.require_in("empty_v", 1, full_v_);
    capacity_as_ = 3600 * params.require_in("capacity_ah", 0.1, 1000);
    resistance_ohm_ = params.require_in("resistance_ohm", 0, 1);
    rate_ = base::RateGate(params.require_in("rate_hz", 0.1, 50));

    // What it hears: how fast the rotors turn.
    torque_coefficient_ = context.vehicle().rotors[0].params.torque_coefficient;
    rotors_ = context.bus().subscribe<sim::RotorSpeeds>(
        context.topic("rotor_speeds"),
        [this](const sim::RotorSpeeds& rotors) { omega_rad_s_ = rotors.omega_rad_s; });

    // What it tells: messages to the controller, figures to the report.
    mavlink_ = context.mavlink();
    voltage_ = context.figure("voltage", "V");
    current_ = context.figure("current", "A");
    lowest_ = context.figure("lowest voltage", "V", sim::FigureKind::kScalar);
    reset();
  }

  void post_step(const sim::StepInfo& step, const sim::World&) override {
    // P = sum of k_m w^3, [HILS] Eq. (2).
    const double power_w = torque_coefficient_ * omega_rad_s_.array().cube().sum();
    const double open_v = full_v_ - (full_v_ - empty_v_) * std::min(drawn_as_ / capacity_as_, 1.0);
    const double current_a = power_w / open_v;
    const double voltage_v = std::max(open_v - resistance_ohm_ * current_a, 0.0);
    drawn_as_ += current_a * base::to_seconds(step.dt);
    lowest_v_ = std::min(lowest_v_, voltage_v);
    if (rate_.due(step.time)) tell(step.time, voltage_v, current_a);
  }

  void reset() override {
    rate_.reset();
    drawn_as_ = 0;
    lowest_v_ = full_v_;
    omega_rad_s_.setZero();
  }

 private:
  void tell(base::SimTime time, double voltage_v, double current_a) {
    BatteryStatus status;
    status.id = 1;  // by battery 0 the emulated controller flies
    status.voltages.fill(UINT16_MAX);
    status.voltages[0] = static_cast<std::uint16_t>(1000 * voltage_v);
    status.set_current_battery_a(current_a);
    status.set_current_consumed_ah(drawn_as_ / 3600);
    status.battery_remaining =
        static_cast<std::int8_t>(100 * std::max(1 - drawn_as_ / capacity_as_, 0.0));
    mavlink_.publish(sim::mavlink_message(status));

    voltage_.publish({time, voltage_v});
    current_.publish({time, current_a});
    lowest_.publish({time, lowest_v_});
  }

  double full_v_ = 0;
  double empty_v_ = 0;
  double capacity_as_ = 0;
  double resistance_ohm_ = 0;
  double torque_coefficient_ = 0;
  base::RateGate rate_;
  base::RotorVector omega_rad_s_ = base::RotorVector::Zero(4);
  double drawn_as_ = 0;
  double lowest_v_ = 0;
  sim::Subscription rotors_;
  sim::Publisher<sim::MavlinkMessage> mavlink_;
  sim::Publisher<sim::FigureSample> voltage_, current_, lowest_;
};

}  // namespace

CAS_PLUGIN(BatteryPlugin, "battery")
CAS_PLUGIN_SENDS("BATTERY_STATUS")
