// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/hil_messages.hpp"

#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"

namespace cas::fcu {

using base::RunTime;
using base::SimTime;
using Eigen::Vector3d;
using mavlink::common::HilActuatorControls;
using mavlink::common::HilControls;
using mavlink::common::HilGps;
using mavlink::common::HilSensor;
using mavlink::common::HilSensorUpdatedFlags;
using mavlink::common::MavMode;
using mavlink::common::MavModeFlag;

// HIL_SENSOR and HIL_GPS in.

namespace {

using F = HilSensorUpdatedFlags;

constexpr F kAccel = F::kXacc | F::kYacc | F::kZacc;
constexpr F kGyro = F::kXgyro | F::kYgyro | F::kZgyro;
constexpr F kMag = F::kXmag | F::kYmag | F::kZmag;
constexpr std::uint64_t kRestart_us = 1'000'000;  // a jump back this far is a new run

/// A group counts only when all of its bits are set, as in PX4.
bool all(F flags, F group) { return (flags & group) == group; }

Vector3d vec(float x, float y, float z) {
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

}  // namespace

void SensorInput::note_age(std::uint64_t time_usec, RunTime now) {
  const std::int64_t delay =
      now.time_since_epoch().count() - static_cast<std::int64_t>(time_usec) * 1000;
  smallest_delay_ns_ = std::min(smallest_delay_ns_, delay);
  age_.add(base::Duration(delay - smallest_delay_ns_));
}

/// The time stood still or went back a little, or is none.
bool SensorInput::is_stale(std::uint64_t time_usec) const {
  if (time_usec > base::kLatestTimeUsec) return true;
  return started_ && time_usec <= last_usec_ && !is_new_run(time_usec);
}

/// The time went back so far that the simulation has begun anew.
bool SensorInput::is_new_run(std::uint64_t time_usec) const {
  return started_ && time_usec <= last_usec_ && last_usec_ - time_usec >= kRestart_us;
}

/// A new simulation: the estimate begins anew and the rotors stop.
void SensorInput::begin_new_run(FcuCore& core) {
  core.texts.warn("Sensor time went back: estimator restarted");
  core.commander.disarm(true);
  core.restart_estimate();
  gate_set_ = false;
  last_time_ = {};
  started_ = false;
  smallest_delay_ns_ = std::numeric_limits<std::int64_t>::max();
}

void SensorInput::feed_estimator(const HilSensor& m, SimTime time, FcuCore& core, RunTime now) {
  const F flags = m.fields_updated;
  if (all(flags, kAccel) && all(flags, kGyro)) {
    const ImuInput imu{time, vec(m.xgyro, m.ygyro, m.zgyro), vec(m.xacc, m.yacc, m.zacc)};
    core.sensors.on_sample(SensorHealth::kImu, imu.gyro_D + imu.accel_D, now);
    core.vibration.update(imu.accel_D);
    core.estimator.on_imu(imu);
    const double dt = started_ ? base::to_seconds(time - last_time_) : 0.0;
    core.cascade.on_rates(core.estimator.state().w_D, dt);
  }
  if (all(flags, kMag)) {
    const Vector3d field = vec(m.xmag, m.ymag, m.zmag);
    core.sensors.on_sample(SensorHealth::kMag, field, now);
    core.estimator.on_magnetometer(time, field);
  }
  if (all(flags, F::kAbsPressure)) {
    core.last_pressure_hpa = static_cast<double>(m.abs_pressure);
    core.last_temperature_degc = static_cast<double>(m.temperature);
    core.sensors.on_sample(SensorHealth::kBaro, Vector3d(core.last_pressure_hpa, 0, 0), now);
    core.estimator.on_barometer(time, 100 * core.last_pressure_hpa);
  }
}

bool SensorInput::on_sensor(const HilSensor& m, FcuCore& core, RunTime now) {
  if (is_stale(m.time_usec)) {
    ++stale_;
    return false;
  }
  if (is_new_run(m.time_usec)) begin_new_run(core);
  last_usec_ = m.time_usec;
  note_age(m.time_usec, now);
  if (core.observer) core.observer(HilSensor::kId, m.time_usec, false);
  core.status.sensor_time_usec = m.time_usec;

  // By the message's own time, or by its arrival.
  const bool by_arrival = core.params.get_int("CAS_STAMP_MODE") == 1;
  SimTime time = by_arrival ? SimTime(now - core.start) : base::from_time_usec(m.time_usec);
  if (started_ && time <= last_time_) time = last_time_ + std::chrono::microseconds(1);
  feed_estimator(m, time, core, now);
  last_time_ = time;
  started_ = true;
  return true;
}

bool SensorInput::control_due(std::uint64_t time_usec, double rate_hz) {
  if (!gate_set_) {
    gate_ = base::RateGate(rate_hz);
    gate_set_ = true;
    last_index_ = -1;
  }
  const SimTime stamp = base::from_time_usec(time_usec);
  if (!gate_.due(stamp)) return false;
  const std::int64_t index = gate_.index_at(stamp.time_since_epoch());
  if (last_index_ >= 0 && index > last_index_ + 1) {
    missed_controls_ += static_cast<std::uint64_t>(index - last_index_ - 1);
  }
  last_index_ = index;
  return true;
}

void SensorInput::on_gps(const HilGps& m, FcuCore& core, RunTime now) {
  if (core.observer) core.observer(HilGps::kId, m.time_usec, false);
  core.last_gps = m;
  GpsInput fix;
  const bool by_arrival = core.params.get_int("CAS_STAMP_MODE") == 1;
  // By arrival only the receiver's usual delay is known; by the message its own stamp tells it.
  fix.time = by_arrival ? SimTime(now - core.start) -
                              base::from_seconds(core.estimator.params().gps_delay_s)
                        : base::from_time_usec(m.time_usec);
  fix.fix_type = m.fix_type;
  fix.place = {m.lat * 1e-7, m.lon * 1e-7, m.alt * 1e-3};
  fix.velocity_N = Vector3d(m.vn, m.ve, m.vd) * 0.01;
  if (fix.fix_type >= 3) {
    core.sensors.on_sample(SensorHealth::kGps, fix.velocity_N, now);
  }
  core.estimator.on_gps(fix);
}

// HIL_CONTROLS or HIL_ACTUATOR_CONTROLS out.

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

void send_motor_outputs(const MixerResult& result, std::uint64_t time_usec, FcuCore& core) {
  const bool armed = core.commander.armed();
  HilActuatorControls answer;
  answer.time_usec = time_usec;
  if (armed) {
    const auto outputs = core.cascade.mixer().outputs(result);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      answer.controls[i] = output(outputs[i], -1, 1);
    }
  }
  answer.mode = static_cast<MavModeFlag>(answer_mode(armed));
  core.outbox.send(answer);
}

}  // namespace

void send_answer(const MixerResult& output, std::uint64_t time_usec, FcuCore& core) {
  const bool by_motor = core.params.get_int("CAS_HIL_ACT") != 0;
  if (by_motor) {
    send_motor_outputs(output, time_usec, core);
  } else {
    send_controls(output.u, time_usec, core);
  }
  const std::uint32_t id = by_motor ? HilActuatorControls::kId : HilControls::kId;
  if (core.observer) core.observer(id, time_usec, true);
}

}  // namespace cas::fcu
