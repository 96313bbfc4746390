// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/sensor_input.hpp"

#include "fcu/core/fcu_core.hpp"

namespace cas::fcu {

using base::RunTime;
using base::SimTime;
using Eigen::Vector3d;
using mavlink::common::HilGps;
using mavlink::common::HilSensor;
using mavlink::common::HilSensorUpdatedFlags;

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

bool SensorInput::accept_time(std::uint64_t time_usec, FcuCore& core) {
  if (time_usec > base::kLatestTimeUsec) {
    ++stale_;
    return false;
  }
  if (started_ && time_usec <= last_usec_) {
    if (last_usec_ - time_usec < kRestart_us) {
      ++stale_;
      return false;
    }
    // The simulation began anew: so does the estimate. The rotors stop with it.
    core.texts.warn("Sensor time went back: estimator restarted");
    core.commander.disarm(true);
    core.restart_estimate();
    gate_set_ = false;
    last_time_ = {};
    started_ = false;
    smallest_delay_ns_ = std::numeric_limits<std::int64_t>::max();
  }
  last_usec_ = time_usec;
  return true;
}

void SensorInput::feed_estimator(const HilSensor& m, SimTime time, FcuCore& core, RunTime now) {
  const F flags = m.fields_updated;
  if (all(flags, kAccel) && all(flags, kGyro)) {
    const ImuInput imu{time, vec(m.xgyro, m.ygyro, m.zgyro), vec(m.xacc, m.yacc, m.zacc)};
    core.sensors.on_sample(SensorMonitor::kImu, imu.gyro_D + imu.accel_D, now);
    core.vibration.update(imu.accel_D);
    core.estimator.on_imu(imu);
    const double dt = started_ ? base::to_seconds(time - last_time_) : 0.0;
    core.cascade.on_rates(core.estimator.state().w_D, dt);
  }
  if (all(flags, kMag)) {
    const Vector3d field = vec(m.xmag, m.ymag, m.zmag);
    core.sensors.on_sample(SensorMonitor::kMag, field, now);
    core.estimator.on_magnetometer(time, field);
  }
  if (all(flags, F::kAbsPressure)) {
    core.last_pressure_hpa = static_cast<double>(m.abs_pressure);
    core.last_temperature_degc = static_cast<double>(m.temperature);
    core.sensors.on_sample(SensorMonitor::kBaro, Vector3d(core.last_pressure_hpa, 0, 0), now);
    core.estimator.on_barometer(time, 100 * core.last_pressure_hpa);
  }
}

bool SensorInput::on_sensor(const HilSensor& m, FcuCore& core, RunTime now) {
  if (!accept_time(m.time_usec, core)) return false;
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
    core.sensors.on_sample(SensorMonitor::kGps, fix.velocity_N, now);
  }
  core.estimator.on_gps(fix);
}

}  // namespace cas::fcu
