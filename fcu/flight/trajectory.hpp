// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fcu/control/setpoint.hpp"

namespace cas::fcu {

/// How fast a setpoint may move: horizontally where nothing else is said; all positive.
struct MoverLimits {
  double speed_m_s = 5;
  double up_m_s = 2;
  double down_m_s = 1.2;
  double acceleration_m_s2 = 3;
  double acceleration_up_m_s2 = 3;
  double acceleration_down_m_s2 = 2;
  double jerk_m_s3 = 8;
  double yaw_rate_rad_s = 1;
};

/// Leads a setpoint to a target with limited speed, acceleration and jerk: straight in the
/// horizontal, independent in height, turning to a heading. Comes to rest at the target.
class Mover {
 public:
  void set_limits(const MoverLimits& limits) { limits_ = limits; }

  /// Starts from a state of motion.
  void reset(const Eigen::Vector3d& p_N, const Eigen::Vector3d& v_N, double yaw_rad);
  /// @param p_N  where to go, m
  void set_target(const Eigen::Vector3d& p_N) { target_N_ = p_N; }
  /// @param yaw_rad  heading of Dx from north, rad
  void set_yaw(double yaw_rad) { target_yaw_ = yaw_rad; }
  /// Moves everything at once, as the estimate was moved.
  void shift(const Eigen::Vector3d& by_N);

  /// Advances by dt (s).
  TrajectorySetpoint update(double dt);

  /// In N, m.
  const Eigen::Vector3d& target() const { return target_N_; }
  /// rad
  double target_yaw() const { return target_yaw_; }
  /// Present setpoint, in N, m.
  const Eigen::Vector3d& position() const { return p_N_; }
  /// Yaw of the present setpoint, rad.
  double yaw() const { return yaw_; }
  /// Whether the setpoint has reached the target.
  bool arrived() const;

 private:
  void step_horizontal(double dt);
  void step_vertical(double dt);
  void step_yaw(double dt);

  MoverLimits limits_;
  Eigen::Vector3d target_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d a_N_ = Eigen::Vector3d::Zero();
  double target_yaw_ = 0;
  double yaw_ = 0;
  double yaw_rate_ = 0;
};

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
