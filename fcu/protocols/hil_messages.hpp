// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>

#include "base/measure/histogram.hpp"
#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::fcu {

struct FcuCore;
struct MixerResult;

/// From HIL_SENSOR and HIL_GPS to the estimator; says when a control step is due.
class SensorInput {
 public:
  /// @return false for a sample whose time stood still or went back: nothing was done with it
  bool on_sensor(const mavlink::common::HilSensor& m, FcuCore& core, base::RunTime now);
  void on_gps(const mavlink::common::HilGps& m, FcuCore& core, base::RunTime now);
  /// Whether the sample with this stamp falls into a new control period, on the grid of the
  /// sensor's clock.
  bool control_due(std::uint64_t time_usec, double rate_hz);

  std::uint64_t stale() const { return stale_; }
  std::uint64_t missed_controls() const { return missed_controls_; }
  /// How much later than the promptest one the sensor messages came.
  const base::Histogram& age() const { return age_; }

 private:
  void note_age(std::uint64_t time_usec, base::RunTime now);
  bool is_stale(std::uint64_t time_usec) const;
  bool is_new_run(std::uint64_t time_usec) const;
  void begin_new_run(FcuCore& core);
  void feed_estimator(const mavlink::common::HilSensor& m, base::SimTime time, FcuCore& core,
                      base::RunTime now);

  base::RateGate gate_{400};
  bool gate_set_ = false;
  std::int64_t last_index_ = -1;
  std::uint64_t last_usec_ = 0;
  base::SimTime last_time_{};
  bool started_ = false;
  std::int64_t smallest_delay_ns_ = std::numeric_limits<std::int64_t>::max();
  std::uint64_t stale_ = 0;
  std::uint64_t missed_controls_ = 0;
  base::Histogram age_;
};

/// Sends U1..U4 as shares of their full scales (HIL_CONTROLS), or the outputs of motors and servos
/// (HIL_ACTUATOR_CONTROLS) where CAS_HIL_ACT says so.
///
/// @param time_usec  stamp of the HIL_SENSOR that the answer was computed from; it is echoed
void send_answer(const MixerResult& output, std::uint64_t time_usec, FcuCore& core);

}  // namespace cas::fcu
