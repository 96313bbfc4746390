// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <variant>

#include "base/measure/histogram.hpp"
#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "fcu/core/fcu_core.hpp"
#include "fcu/estimation/gps_vote.hpp"
#include "fcu/estimation/imu_vote.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/odometry.hpp"

namespace cas::fcu {

/// From HIL_SENSOR, HIL_GPS and ODOMETRY to the estimator; says when a control step is due.
///
/// Packets with an id from 1 on are of further IMUs and receivers: a vote chooses the one to fly
/// by. Those of id 0 are the clock. Further compasses and barometers are not used.
class SensorInput {
 public:
  /// What the input feeds and reads. All outlive it.
  struct View {
    Estimator& estimator;
    ControlCascade& cascade;
    SensorReadings& readings;
    const HilParams& params;
    const base::RunTime& start;
    StatusTexts& texts;
  };
  explicit SensorInput(const View& view) : to_(view) {}

  enum class Sample {
    kStale,  ///< its time stood still or went back a little, or is none: to be left out
    kNext,
    kNewRun,  ///< its time went back far: the simulation restarted
  };
  /// Judges a sample by its stamp, and counts it.
  Sample accept(std::uint64_t time_usec, base::RunTime now);
  /// A sample that is not stale.
  void on_sensor(const mavlink::common::HilSensor& m, base::RunTime now);
  void on_gps(const mavlink::common::HilGps& m, base::RunTime now);
  /// Where no receiver has a fix, the pose counts as one about the origin of the estimate, which
  /// must be known: MAV_FRAME_LOCAL_NED, velocity in MAV_FRAME_BODY_FRD, of a sensor that has not
  /// failed. Its covariances are not used.
  void on_odometry(const mavlink::common::Odometry& m, base::RunTime now);
  /// The same of an id from 1 on: noted for the next sample of id 0.
  void on_further_sensor(const mavlink::common::HilSensor& m, base::RunTime now);
  /// Whether the sample with this stamp falls into a new control period, on the grid of the
  /// sensor's clock.
  bool control_due(std::uint64_t time_usec, double rate_hz);

  std::uint64_t stale() const { return stale_; }
  std::uint64_t missed_controls() const { return missed_controls_; }
  /// How much later than the promptest one the sensor messages came.
  const base::Histogram& age() const { return age_; }

 private:
  void note_age(std::uint64_t time_usec, base::RunTime now);
  void feed_estimator(const mavlink::common::HilSensor& m, base::SimTime time, base::RunTime now);
  void use_imu(const ImuInput& imu, base::RunTime now);
  std::optional<ImuInput> choose_imu(const std::optional<ImuInput>& first, base::SimTime time);
  RepeatedFixes::Fix digits(const mavlink::common::HilGps& m, const GpsInput& fix) const;
  /// Whether the receiver that the fix is of is flown by.
  bool choose_receiver(const mavlink::common::HilGps& m, const GpsInput& fix, base::RunTime now);

  View to_;
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
  ImuVote imus_;
  GpsVote receivers_;
  std::optional<base::RunTime> last_fix_;
};

/// Reading of battery 0; nullopt for another battery, and without a voltage or the remaining
/// charge.
std::optional<Battery::Reading> battery_reading(const mavlink::common::BatteryStatus& m);

/// Inputs of make_answer().
struct AnswerInput {
  const MixerResult& result;
  const Mixer& mixer;
  const WingController* wing = nullptr;  ///< of a plane or VTOL
  const base::ControlScales& scales;
  std::uint64_t time_usec = 0;  ///< stamp of the HIL_SENSOR that it was computed from; it is echoed
  bool armed = false;
  bool by_motor = false;  ///< CAS_HIL_ACT
};
/// U1..U4 as shares of their full scales, or the outputs of motors and servos.
using Answer = std::variant<mavlink::common::HilControls, mavlink::common::HilActuatorControls>;
/// The answer to a HIL_SENSOR.
Answer make_answer(const AnswerInput& input);

}  // namespace cas::fcu
