// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fcu/control/setpoint.hpp"

namespace cas::fcu {

enum class PatternShape { kNone = 0, kCircle = 1, kFigureEight = 2, kSteps = 3 };

/// A path about a centre, as position, velocity and acceleration at a time.
///
/// kCircle: radius `size`, speed `speed`. kFigureEight: Gerono's lemniscate, `size` from the centre
/// to each end, greatest speed `speed`. kSteps: `size` forth and back along north every `period`.
/// Circle and eight start from rest and take `kStart_s` to come up to speed.
class Pattern {
 public:
  Pattern(PatternShape shape, double size_m, double speed_m_s, double period_s)
      : shape_(shape), size_m_(size_m), speed_m_s_(speed_m_s), period_s_(period_s) {}

  /// @param time_s  since the start
  TrajectorySetpoint at(double time_s, const Eigen::Vector3d& centre_N, double yaw_rad) const;

  static constexpr double kStart_s = 4;

 private:
  struct Phase {
    double angle = 0, rate = 0, acceleration = 0;
  };
  Phase phase_at(double time_s, double full_rate) const;

  PatternShape shape_;
  double size_m_;
  double speed_m_s_;
  double period_s_;
};

}  // namespace cas::fcu
