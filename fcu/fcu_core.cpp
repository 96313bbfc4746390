// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/fcu_core.hpp"

#include <algorithm>
#include <cmath>

#include "base/frames.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"

namespace cas::fcu {

using mavlink::common::HilActuatorControls;
using mavlink::common::HilControls;
using mavlink::common::MavMode;
using mavlink::common::MavModeFlag;

void FcuCore::apply_params() {
  if (params_applied == params.revision()) return;
  params_applied = params.revision();
  flight = flight_params(params);
  estimator.set_params(estimator_params(params));
  cascade.set_params(control_params(params));
  battery.set_params({params.get("SIM_BAT_DRAIN"), params.get("SIM_BAT_MIN_PCT") / 100,
                      params.get_int("BAT1_N_CELLS")});
}

std::optional<Sticks> FcuCore::sticks(base::RunTime now) const {
  // COM_RC_IN_MODE: 0 radio only, 1 MANUAL_CONTROL only, 2 and 3 either, 4 none.
  const int mode = flight.manual_input;
  const auto fresh = [&](const ManualInput& input) {
    return input.seen && base::to_seconds(now - input.last) < flight.manual_timeout_s;
  };
  if (mode != 0 && mode != 4 && fresh(manual_control)) return manual_control.sticks;
  if (mode != 1 && mode != 4 && fresh(rc_input)) return rc_input.sticks;
  return std::nullopt;
}

TaskContext FcuCore::context(base::RunTime now, double dt) const {
  TaskContext c;
  c.estimate = estimator.state();
  c.yaw_rad = base::euler_rpy(c.estimate.q_ND).z();
  c.position_valid = estimator.position_valid() && estimator.heading_valid();
  c.height_valid = estimator.height_valid();
  c.params = flight;
  c.home_N = home_N;
  c.ground_z = ground_z;
  c.projection = estimator.projection();
  c.sticks = sticks(now);
  c.full_thrust_n = config.vehicle.scales.u1_max_n;
  c.now = now;
  c.dt = dt;
  return c;
}

ArmingInput FcuCore::arming_input(base::RunTime now) const {
  const std::optional<Sticks> pilot = sticks(now);
  return {estimator,
          sensors,
          flight,
          commander.mode(),
          pilot.has_value(),
          pilot ? pilot->throttle : 0.0,
          battery.remaining(),
          now};
}

FailsafeInput FcuCore::failsafe_input(base::RunTime now) const {
  FailsafeInput in;
  const Eigen::Vector3d rpy = base::euler_rpy(estimator.state().q_ND);
  in.roll_rad = rpy.x();
  in.pitch_rad = rpy.y();
  in.position_valid = estimator.position_valid() && estimator.heading_valid();
  in.height_valid = estimator.height_valid();
  in.imu_alive = sensors.alive(SensorMonitor::kImu, now);
  in.mag_alive = sensors.alive(SensorMonitor::kMag, now);
  in.baro_alive = sensors.alive(SensorMonitor::kBaro, now);
  in.gps_alive = sensors.alive(SensorMonitor::kGps, now);
  in.ground_station_seen = ground_station_seen;
  in.ground_station_alive =
      base::to_seconds(now - ground_station_last) < flight.ground_station_timeout_s;
  in.sticks_seen = manual_control.seen || rc_input.seen;
  in.sticks_alive = sticks(now).has_value();
  in.battery = battery.remaining();
  return in;
}

void FcuCore::set_home_here() {
  home_N = estimator.state().p_N;
  home_yaw_rad = base::euler_rpy(estimator.state().q_ND).z();
  ground_z = home_N.z();
  home_set = true;
}

namespace {

/// MAV_MODE_FLAG bits of the answer: HIL always, armed as it is.
std::uint8_t answer_mode(bool armed) {
  const MavModeFlag flags =
      armed ? MavModeFlag::kHilEnabled | MavModeFlag::kSafetyArmed : MavModeFlag::kHilEnabled;
  return static_cast<std::uint8_t>(flags);
}

float scaled(double value, double full, double low) {
  return static_cast<float>(std::clamp(full > 0 ? value / full : 0.0, low, 1.0));
}

}  // namespace

void FcuCore::control(base::RunTime now, std::uint64_t time_usec) {
  // Time since the last step, on the sensor's clock.
  const base::SimTime time = base::from_time_usec(time_usec);
  const double period = 1.0 / config.control_rate_hz;
  const double elapsed = controlled ? base::to_seconds(time - last_control) : period;
  const double dt = std::clamp(elapsed, 0.2 * period, 10 * period);
  last_control = time;
  controlled = true;

  // While disarmed the place the vehicle stands at is known better with every fix.
  if (!commander.armed() && estimator.origin_final()) set_home_here();
  if (estimator.position_resets() != position_resets_seen) {
    position_resets_seen = estimator.position_resets();
    commander.on_position_reset(estimator.last_position_reset_N());
  }

  const TaskContext task = context(now, dt);
  const double thrust_ratio = cascade.output().u[0] / std::max(cascade.hover_thrust_n(), 1e-3);
  FailsafeInput failsafe = failsafe_input(now);
  failsafe.offboard_alive = commander.offboard().alive(now, flight.offboard_timeout_s);
  const ControlSetpoint setpoint = commander.update(task, failsafe, thrust_ratio);
  const MixerResult& out = cascade.update(setpoint, estimator.state(), dt);
  estimator.set_at_rest(!commander.flying());
  battery.update(commander.armed(), dt);

  // The answer.
  const auto& scales = config.vehicle.scales;
  if (params.get_int("CAS_HIL_ACT") == 0) {
    HilControls answer;
    answer.time_usec = time_usec;
    answer.roll_ailerons = scaled(out.u[1], scales.u2_max_nm, -1);
    answer.pitch_elevator = scaled(out.u[2], scales.u3_max_nm, -1);
    answer.yaw_rudder = scaled(out.u[3], scales.u4_max_nm, -1);
    answer.throttle = scaled(out.u[0], scales.u1_max_n, 0);
    answer.mode = static_cast<MavMode>(answer_mode(commander.armed()));
    outbox.send(answer);
    if (observer) observer(HilControls::kId, time_usec, true);
  } else {
    HilActuatorControls answer;
    answer.time_usec = time_usec;
    const Eigen::Vector4d motors = cascade.mixer().motor_outputs(out.omega_sq);
    for (int i = 0; i < 4; ++i) {
      answer.controls[static_cast<std::size_t>(i)] =
          commander.armed() ? static_cast<float>(motors[i]) : 0.0F;
    }
    answer.mode = static_cast<MavModeFlag>(answer_mode(commander.armed()));
    outbox.send(answer);
    if (observer) observer(HilActuatorControls::kId, time_usec, true);
  }
  status.u = out.u;
}

}  // namespace cas::fcu
