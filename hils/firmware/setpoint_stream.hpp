// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "fcu/flight/trajectory.hpp"
#include "hils/measure/firmware_record.hpp"
#include "mavlink/common/set_position_target_local_ned.hpp"

namespace cas::hils {

/// Setpoints for a stock autopilot, on the vehicle's own clock: position, velocity and heading in
/// its local frame N (SET_POSITION_TARGET_LOCAL_NED). No I/O; the vehicle's time comes in.
class SetpointStream {
 public:
  /// PX4 takes 2 Hz for a stream that lives; a position loop follows 50 Hz without steps.
  static constexpr double kRate_hz = 50;

  /// From now on one place, north-east-down in m, and a heading in rad.
  void hover(const Eigen::Vector3d& p_N, double yaw_rad);
  /// From this moment of the vehicle's clock on a pattern about that place.
  void fly(const fcu::Pattern& pattern, base::Duration vehicle_time);
  /// The same to another place, straight ahead; there it hovers.
  void fly_to(const Eigen::Vector3d& p_N, double speed_m_s, base::Duration vehicle_time);
  void stop();

  /// The vehicle's clock has gone on. @return the setpoint that is due, without an addressee
  std::optional<mavlink::common::SetPositionTargetLocalNed> update(base::Duration vehicle_time);

  /// For how long the stream has lived without a gap of `kAlive`, by the vehicle's clock.
  base::Duration alive_for() const { return began_ ? newest_ - *began_ : base::Duration{}; }
  /// Since the first hover().
  const SetpointFigures& figures() const { return figures_; }

 private:
  /// A flight straight ahead from the centre.
  struct Line {
    Eigen::Vector3d end_N;
    double speed_m_s = 0;
  };

  fcu::TrajectorySetpoint at(base::Duration vehicle_time) const;
  fcu::TrajectorySetpoint on_line(double seconds) const;

  bool on_ = false;
  Eigen::Vector3d centre_N_ = Eigen::Vector3d::Zero();
  double yaw_rad_ = 0;
  std::optional<fcu::Pattern> pattern_;
  std::optional<Line> line_;
  base::Duration begin_{};  ///< of pattern or line
  base::RateGate gate_{kRate_hz};
  std::optional<base::Duration> began_;
  base::Duration newest_{};
  SetpointFigures figures_;
};

}  // namespace cas::hils
