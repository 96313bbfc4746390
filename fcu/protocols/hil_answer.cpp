// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/hil_answer.hpp"

#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"

namespace cas::fcu {

using mavlink::common::HilActuatorControls;
using mavlink::common::HilControls;
using mavlink::common::MavMode;
using mavlink::common::MavModeFlag;

namespace {

/// MAV_MODE_FLAG bits of the answer: HIL always, armed as it is.
std::uint8_t answer_mode(bool armed) {
  const MavModeFlag flags =
      armed ? MavModeFlag::kHilEnabled | MavModeFlag::kSafetyArmed : MavModeFlag::kHilEnabled;
  return static_cast<std::uint8_t>(flags);
}

float scaled(double value, double full, double low) {
  return output(full > 0 ? value / full : 0.0, low, 1.0);
}

void send_controls(const Eigen::Vector4d& u, std::uint64_t time_usec, FcuCore& core) {
  const auto& scales = core.config.vehicle.scales;
  HilControls answer;
  answer.time_usec = time_usec;
  answer.roll_ailerons = scaled(u[1], scales.u2_max_nm, -1);
  answer.pitch_elevator = scaled(u[2], scales.u3_max_nm, -1);
  answer.yaw_rudder = scaled(u[3], scales.u4_max_nm, -1);
  answer.throttle = scaled(u[0], scales.u1_max_n, 0);
  answer.mode = static_cast<MavMode>(answer_mode(core.commander.armed()));
  core.outbox.send(answer);
}

void send_motor_outputs(const Eigen::Vector4d& omega_sq, std::uint64_t time_usec, FcuCore& core) {
  const bool armed = core.commander.armed();
  HilActuatorControls answer;
  answer.time_usec = time_usec;
  if (armed) {
    const Eigen::Vector4d motors = core.cascade.mixer().motor_outputs(omega_sq);
    for (std::size_t i = 0; i < 4; ++i) {
      answer.controls[i] = output(motors[static_cast<int>(i)], 0, 1);
    }
  }
  answer.mode = static_cast<MavModeFlag>(answer_mode(armed));
  core.outbox.send(answer);
}

}  // namespace

void send_answer(const MixerResult& output, std::uint64_t time_usec, FcuCore& core) {
  const bool by_motor = core.params.get_int("CAS_HIL_ACT") != 0;
  if (by_motor) {
    send_motor_outputs(output.omega_sq, time_usec, core);
  } else {
    send_controls(output.u, time_usec, core);
  }
  const std::uint32_t id = by_motor ? HilActuatorControls::kId : HilControls::kId;
  if (core.observer) core.observer(id, time_usec, true);
}

}  // namespace cas::fcu
