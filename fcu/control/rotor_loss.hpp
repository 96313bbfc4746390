// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/control/control_allocation.hpp"
#include "fcu/control/mixer_result.hpp"

namespace cas::fcu {

/// Finds a rotor that has lost its thrust, from the missing moments.
///
/// The controller does not measure rotor speeds. It knows the commanded speeds, which the rotors
/// follow with their time constants, and the body rates. A momentum observer (A. De Luca and R.
/// Mattone, "Sensorless robot collision detection and hybrid force/motion control", IEEE ICRA 2005)
/// estimates from them the uncommanded moment, without differentiating the rates:
///
///   r = K (I w - integral(M omega^2 - w x I w + r)),   r -> that moment, lagged by 1/K
///
/// The slow part of r comes from wind and centre of gravity and is subtracted. If the rest matches
/// the missing moment of one rotor best, in direction and size, for long enough, that rotor is
/// lost.
/// Servos are assumed to follow commanded tilts with their lag and their fastest rate. Slow rotors
/// are not checked, a rotor that keeps a good part of its thrust is not found, and the roll moments
/// of the upper and lower rotor of a coaxial pair differ by their yaw alone.
class RotorLossDetector {
 public:
  explicit RotorLossDetector(const base::Vehicle& vehicle);

  /// Restarts detection: on the ground, or after a change of the allocation.
  void reset() { started_ = false; }

  /// One control step in free flight.
  /// @param w_D    measured body rates, rad/s
  /// @param asked  speeds and tilts asked for from now on
  /// @param lost   rotors that are known to be lost
  /// @param dt     s since the last step
  /// @return index of a rotor that is lost, once
  std::optional<int> update(const Eigen::Vector3d& w_D, const MixerResult& asked, RotorSet lost,
                            double dt);

  /// Uncommanded moment without its slow part, axes of D, N m.
  Eigen::Vector3d residual_D() const { return residual_D_ - slow_D_; }

 private:
  void take_axes();
  void follow_speeds(const base::RotorVector& omega_sq, double dt);
  void follow_tilts(const base::RotorVector& tilt_rad, double dt);
  void observe(const Eigen::Vector3d& w_D, double dt);
  int suspect(RotorSet lost) const;

  base::Vehicle vehicle_;
  base::Vehicle apart_;  // the same without wakes
  bool has_servos_ = false;
  using Moments = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, base::kMaxRotors>;
  Moments moment_D_;        // with the axes as they are tilted
  Moments loss_D_;          // lost with a rotor; the one below it regains its wake loss
  Eigen::Vector3d weight_;  // makes the axes comparable
  base::RotorVector up_s_, down_s_, high_;
  base::RotorVector omega_;       // as the rotors should turn, rad/s
  std::vector<double> tilt_rad_;  // as the servos should stand
  bool started_ = false;
  Eigen::Vector3d momentum_start_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d integral_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d residual_D_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d slow_D_ = Eigen::Vector3d::Zero();
  double quiet_s_ = 0;  // since the start
  int suspect_ = -1;
  double suspected_s_ = 0;
};

}  // namespace cas::fcu
