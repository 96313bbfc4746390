// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/hil_messages.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/earth/deg_e7.hpp"
#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"

namespace cas::fcu {

using base::RunTime;
using base::SimTime;
using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT: the file is about its messages

// HIL_SENSOR, HIL_GPS and ODOMETRY in.

namespace {

using F = HilSensorUpdatedFlags;

constexpr F kAccel = F::kXacc | F::kYacc | F::kZacc;
constexpr F kGyro = F::kXgyro | F::kYgyro | F::kZgyro;
constexpr F kMag = F::kXmag | F::kYmag | F::kZmag;
constexpr std::uint64_t kRestart_us = 1'000'000;  // a jump back this far is a new run
constexpr int kFixIn3d = 3;                       // GPS_FIX_TYPE_3D_FIX

/// A group counts only when all of its bits are set, as in PX4.
bool all(F flags, F group) { return (flags & group) == group; }

/// Rates and forces of a packet that has both.
std::optional<ImuInput> imu_of(const HilSensor& m, SimTime time) {
  if (!all(m.fields_updated, kAccel) || !all(m.fields_updated, kGyro)) return std::nullopt;
  return ImuInput{time, vec(m.xgyro, m.ygyro, m.zgyro), vec(m.xacc, m.yacc, m.zacc)};
}

const char* in_words(VoteCause cause) {
  switch (cause) {
    case VoteCause::kSilent:
      return "silent";
    case VoteCause::kStuck:
      return "stuck";
    default:
      return "disagrees";
  }
}

/// "IMU 1 stuck: flying by IMU 2": in STATUSTEXT sensors count from 1.
std::string in_words(const char* kind, const VoteSwitch& change) {
  return std::string(kind) + " " + std::to_string(change.from + 1) + " " + in_words(change.cause) +
         ": flying by " + kind + " " + std::to_string(change.to + 1);
}

}  // namespace

void SensorInput::note_age(std::uint64_t time_usec, RunTime now) {
  const std::int64_t delay =
      now.time_since_epoch().count() - static_cast<std::int64_t>(time_usec) * 1000;
  smallest_delay_ns_ = std::min(smallest_delay_ns_, delay);
  age_.add(base::Duration(delay - smallest_delay_ns_));
}

SensorInput::Sample SensorInput::accept(std::uint64_t time_usec, RunTime now) {
  const bool back = started_ && time_usec <= last_usec_;
  const bool is_new_run = back && last_usec_ - time_usec >= kRestart_us;
  if (time_usec > base::kLatestTimeUsec || (back && !is_new_run)) {
    ++stale_;
    return Sample::kStale;
  }
  if (is_new_run) {
    gate_set_ = started_ = false;
    last_time_ = {};
    imus_ = {};
    receivers_ = {};
    last_fix_.reset();
    smallest_delay_ns_ = std::numeric_limits<std::int64_t>::max();
  }
  last_usec_ = time_usec;
  note_age(time_usec, now);
  return is_new_run ? Sample::kNewRun : Sample::kNext;
}

void SensorInput::use_imu(const ImuInput& imu, RunTime now) {
  to_.readings.health.on_imu(imu.gyro_D, imu.accel_D, now);
  to_.readings.vibration.update(imu.accel_D);
  to_.estimator.on_imu(imu);
  const double dt = started_ ? base::to_seconds(imu.time - last_time_) : 0.0;
  to_.cascade.on_rates(to_.estimator.state().w_D, dt);
}

/// The sample to fly by at the time of the clock. @param first  that of the first IMU, if it has
/// one
std::optional<ImuInput> SensorInput::choose_imu(const std::optional<ImuInput>& first,
                                                SimTime time) {
  if (first) imus_.on_sample(0, *first);
  if (!imus_.several()) return first;
  const ImuInput* chosen = imus_.choose(time);
  if (const auto change = imus_.take_switch()) {
    to_.texts.critical(in_words("IMU", *change));
    to_.estimator.forget_imu_biases();
  }
  if (chosen == nullptr) return std::nullopt;
  ImuInput imu = *chosen;
  imu.time = time;
  return imu;
}

void SensorInput::on_further_sensor(const HilSensor& m, RunTime now) {
  const SimTime time =
      to_.params.stamp_by_arrival ? SimTime(now - to_.start) : base::from_time_usec(m.time_usec);
  if (const auto imu = imu_of(m, time)) imus_.on_sample(m.id, *imu);
}

void SensorInput::feed_estimator(const HilSensor& m, SimTime time, RunTime now) {
  SensorReadings& readings = to_.readings;
  const F flags = m.fields_updated;
  if (const auto imu = choose_imu(imu_of(m, time), time)) use_imu(*imu, now);
  if (all(flags, kMag)) {
    const Vector3d field = vec(m.xmag, m.ymag, m.zmag);
    readings.health.on_sample(SensorHealth::kMag, field, now);
    to_.estimator.on_magnetometer(time, field);
  }
  if (all(flags, F::kAbsPressure)) {
    readings.pressure_hpa = static_cast<double>(m.abs_pressure);
    readings.temperature_degc = static_cast<double>(m.temperature);
    readings.airspeed.set_air(100 * readings.pressure_hpa, readings.temperature_degc);
    readings.health.on_sample(SensorHealth::kBaro, Vector3d(readings.pressure_hpa, 0, 0), now);
    to_.estimator.on_barometer(time, 100 * readings.pressure_hpa);
  }
  if (all(flags, F::kDiffPressure)) readings.airspeed.on_sample(m.diff_pressure_pa(), now);
}

void SensorInput::on_sensor(const HilSensor& m, RunTime now) {
  // By the message's own time, or by its arrival.
  SimTime time =
      to_.params.stamp_by_arrival ? SimTime(now - to_.start) : base::from_time_usec(m.time_usec);
  if (started_ && time <= last_time_) time = last_time_ + std::chrono::microseconds(1);
  feed_estimator(m, time, now);
  last_time_ = time;
  started_ = true;
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

/// A fix as it came, and whether the vehicle stands still or moves.
RepeatedFixes::Fix SensorInput::digits(const HilGps& m, const GpsInput& fix) const {
  constexpr double kMoving_m_s = 1.0;  // in 20 ms farther than the digits of a fix
  const double rest_s = to_.estimator.rest_s();
  const double speed = std::max(to_.estimator.state().v_N.norm(), fix.velocity_N.norm());
  return {.time_usec = m.time_usec,
          .digits = {m.lat, m.lon, m.alt, m.vn, m.ve, m.vd},
          .at_rest = rest_s > 0,
          .moving = rest_s <= 0 && speed > kMoving_m_s};
}

bool SensorInput::choose_receiver(const HilGps& m, const GpsInput& fix, RunTime now) {
  constexpr double kFar_m = 5;
  constexpr double kFar_m_s = 3;
  GpsVote::Fix seen{.heard = SimTime(now - to_.start),
                    .has_fix = fix.fix_type >= kFixIn3d && fix.velocity_N.allFinite(),
                    .digits = digits(m, fix),
                    .off = std::nullopt};
  if (const auto offset = to_.estimator.offset_of(fix)) {
    seen.off = std::max(offset->position_m / kFar_m, offset->velocity_m_s / kFar_m_s);
  }
  receivers_.on_fix(m.id, seen);
  if (const auto change = receivers_.take_switch()) {
    to_.texts.critical(in_words("GPS", *change));
  }
  return m.id == receivers_.used();
}

void SensorInput::on_gps(const HilGps& m, RunTime now) {
  GpsInput fix;
  // Stamped by arrival only the receiver's usual delay is known; stamped by the message its stamp
  // gives the delay.
  fix.time = to_.params.stamp_by_arrival
                 ? SimTime(now - to_.start) - base::from_seconds(to_.estimator.params().gps_delay_s)
                 : base::from_time_usec(m.time_usec);
  fix.fix_type = m.fix_type;
  constexpr double kStep_deg = 1 / base::kDegE7;
  fix.place = {m.lat * kStep_deg, m.lon * kStep_deg, m.alt * 1e-3};
  fix.velocity_N = Vector3d(m.vn, m.ve, m.vd) * 0.01;
  if (!choose_receiver(m, fix, now)) return;
  to_.readings.gps = m;
  const bool has_fix = fix.fix_type >= kFixIn3d;
  if (has_fix && !to_.readings.health.on_fix(digits(m, fix), fix.velocity_N, now)) return;
  if (has_fix) last_fix_ = now;
  to_.estimator.on_gps(fix);
}

void SensorInput::on_odometry(const Odometry& m, RunTime now) {
  constexpr double kFixesAreGone_s = 1;
  constexpr float kRoundedNorm = 0.01F;
  if (m.frame_id != MavFrame::kLocalNed || m.child_frame_id != MavFrame::kBodyFrd) return;
  const Vector3d p_N = vec(m.x, m.y, m.z);
  const Vector3d v_D = vec(m.vx, m.vy, m.vz);
  const Eigen::Quaternionf q(m.q[0], m.q[1], m.q[2], m.q[3]);
  const bool has_attitude = std::abs(q.norm() - 1) < kRoundedNorm;  // no NaN passes
  if (m.quality < 0 || !p_N.allFinite() || !v_D.allFinite() || !has_attitude) return;
  to_.readings.health.on_sample(SensorHealth::kOdometry, p_N, now);
  if (!to_.readings.health.alive(SensorHealth::kOdometry, now)) return;  // it repeats itself
  if (last_fix_ && base::to_seconds(now - *last_fix_) < kFixesAreGone_s) return;
  if (!to_.estimator.projection()) return;
  GpsInput fix;
  fix.time =
      to_.params.stamp_by_arrival ? SimTime(now - to_.start) : base::from_time_usec(m.time_usec);
  fix.fix_type = kFixIn3d;
  fix.place = to_.estimator.projection()->to_geodetic(p_N);
  fix.velocity_N = q.cast<double>().normalized() * v_D;
  to_.estimator.on_gps(fix);
}

// BATTERY_STATUS in.

std::optional<Battery::Reading> battery_reading(const BatteryStatus& m) {
  if (m.id != 0 || !m.voltages_known() || m.battery_remaining < 0) return std::nullopt;
  constexpr std::uint16_t kNoCell = 0xFFFF;
  Battery::Reading reading{.voltage_v = 0,
                           .cells = 0,
                           .current_a = m.current_battery * 0.01,
                           .remaining = std::min(1.0, m.battery_remaining * 0.01),
                           .consumed_mah = static_cast<double>(m.current_consumed)};
  for (const std::uint16_t cell_mv : m.voltages) {
    if (cell_mv == kNoCell) break;
    reading.voltage_v += cell_mv * 0.001;
    ++reading.cells;
  }
  return reading;
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

HilControls controls(const AnswerInput& a) {
  const base::ControlScales& scales = a.scales;
  HilControls message;
  message.time_usec = a.time_usec;
  message.roll_ailerons = scaled(a.result.u[1], scales.u2_max_nm, -1);
  message.pitch_elevator = scaled(a.result.u[2], scales.u3_max_nm, -1);
  message.yaw_rudder = scaled(a.result.u[3], scales.u4_max_nm, -1);
  message.throttle = scaled(a.result.u[0], scales.u1_max_n, 0);
  message.mode = static_cast<MavMode>(answer_mode(a.armed));
  return message;
}

HilActuatorControls motor_outputs(const AnswerInput& a) {
  HilActuatorControls message;
  message.time_usec = a.time_usec;
  if (a.armed) {
    auto outputs = a.mixer.outputs(a.result);
    if (a.wing != nullptr) {
      for (std::size_t i = 0; i < outputs.size(); ++i) outputs[i] += a.wing->outputs()[i];
    }
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      message.controls[i] = output(outputs[i], -1, 1);
    }
  }
  message.mode = static_cast<MavModeFlag>(answer_mode(a.armed));
  return message;
}

}  // namespace

Answer make_answer(const AnswerInput& input) {
  if (input.by_motor) return motor_outputs(input);
  return controls(input);
}

}  // namespace cas::fcu
