// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/time/clock.hpp"
#include "fcu/estimation/repeated_fixes.hpp"

namespace cas::fcu {

/// Tells a stuck sensor from a living one: once its values have changed from sample to sample, one
/// that repeats exactly is no measurement.
class StuckValue {
 public:
  /// @return whether the value is a sign of life
  bool update(const Eigen::Vector3d& value) {
    const bool same = value == value_;
    value_ = value;
    changes_ = same ? 0 : changes_ + 1;
    noisy_ = noisy_ || changes_ >= kInARow;
    repeats_ = same && noisy_ ? repeats_ + 1 : 0;
    return repeats_ == 0;
  }
  /// So many repetitions that PX4's DataValidator (VALUE_EQUAL_COUNT_DEFAULT) calls it stale.
  bool stuck() const { return repeats_ >= kInARow; }

 private:
  static constexpr int kInARow = 100;
  Eigen::Vector3d value_ = Eigen::Vector3d::Zero();
  int changes_ = 0;
  int repeats_ = 0;
  bool noisy_ = false;
};

/// Tells living sensors from dead and frozen ones. The HIL input notes each sample here; Commander,
/// failsafes and telemetry ask which sensors live.
class SensorHealth {
 public:
  enum Sensor { kImu, kMag, kBaro, kGps, kOdometry, kSensors };

  /// Notes a sample. A value that repeats exactly is no sign of life: real noise never repeats.
  void on_sample(Sensor sensor, const Eigen::Vector3d& value, base::RunTime now) {
    State& s = states_[sensor];
    if (s.seen && value == s.value && sensor != kGps) return;
    s.value = value;
    s.last = now;
    s.seen = true;
  }
  /// Notes a sample of both; one that is stuck is the loss of both.
  void on_imu(const Eigen::Vector3d& gyro_D, const Eigen::Vector3d& accel_D, base::RunTime now) {
    const bool gyro_lives = gyro_.update(gyro_D);
    const bool accel_lives = accel_.update(accel_D);
    if (gyro_lives && accel_lives) on_sample(kImu, gyro_D + accel_D, now);
  }
  /// Notes a fix. @return whether it is a measurement, to be used
  bool on_fix(const RepeatedFixes::Fix& fix, const Eigen::Vector3d& velocity_N, base::RunTime now) {
    if (!fixes_.accept(fix)) return false;
    on_sample(kGps, velocity_N, now);
    return true;
  }
  /// A new simulation: its receiver starts anew.
  void forget_fixes() { fixes_ = {}; }

  bool alive(Sensor sensor, base::RunTime now) const {
    const State& s = states_[sensor];
    return s.seen && base::to_seconds(now - s.last) < kTimeout_s[sensor];
  }
  bool seen(Sensor sensor) const { return states_[sensor].seen; }
  bool gps_frozen() const { return fixes_.frozen(); }
  bool gyro_stuck() const { return gyro_.stuck(); }
  bool accel_stuck() const { return accel_.stuck(); }

 private:
  struct State {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    base::RunTime last;
    bool seen = false;
  };
  static constexpr double kTimeout_s[kSensors] = {0.5, 2.0, 2.0, 3.0, 0.5};
  State states_[kSensors];
  StuckValue gyro_, accel_;
  RepeatedFixes fixes_;
};

}  // namespace cas::fcu
