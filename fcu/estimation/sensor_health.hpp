// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/time/clock.hpp"

namespace cas::fcu {

/// Tells living sensors from dead and frozen ones.
class SensorHealth {
 public:
  enum Sensor { kImu, kMag, kBaro, kGps, kSensors };

  /// Notes a sample. A value that repeats exactly is no sign of life: real noise never repeats.
  void on_sample(Sensor sensor, const Eigen::Vector3d& value, base::RunTime now) {
    State& s = states_[sensor];
    if (s.seen && value == s.value && sensor != kGps) return;
    s.value = value;
    s.last = now;
    s.seen = true;
  }

  bool alive(Sensor sensor, base::RunTime now) const {
    const State& s = states_[sensor];
    return s.seen && base::to_seconds(now - s.last) < kTimeout_s[sensor];
  }
  bool seen(Sensor sensor) const { return states_[sensor].seen; }

 private:
  struct State {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    base::RunTime last;
    bool seen = false;
  };
  static constexpr double kTimeout_s[kSensors] = {0.5, 2.0, 2.0, 3.0};
  State states_[kSensors];
};

}  // namespace cas::fcu
