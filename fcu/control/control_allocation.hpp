// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/control/mixer_result.hpp"

namespace cas::fcu {

/// Rotors as bits: bit i is rotor i + 1.
using RotorSet = std::uint32_t;
inline bool has(RotorSet set, int rotor) { return (set >> static_cast<unsigned>(rotor) & 1U) != 0; }

/// The controller's demand on the rotors.
struct ControlDemand {
  Eigen::Vector4d u = Eigen::Vector4d::Zero();         ///< U1 (N), U2, U3, U4 (N m)
  Eigen::Vector2d side_D_n = Eigen::Vector2d::Zero();  ///< force along Dx and Dy, N
};

/// Input from which ControlAllocation computes its matrices.
struct AllocationSetup {
  /// A servo that turns a rotor's axis. The rotor's omega^2 then has two parts, both of which act
  /// linearly: omega^2 cos(tilt) in the column of the rotor, omega^2 sin(tilt) in a further one.
  /// Thrust along a hinge that is not at right angles to the rotor's axis does not turn with it;
  /// the inversion takes it for a part of the first column, which is right to the first order.
  struct Servo {
    int rotor = 0;  ///< which one it turns, 0..
    double min_rad = 0;
    double max_rad = 0;
  };

  /// Force and moment (FLU, N s^2 and N m s^2) of each rotor's omega^2, then of each servo's part.
  base::Effectiveness wrench_B;
  base::RotorVector low;     ///< slowest of each rotor, omega^2
  base::RotorVector high;    ///< fastest of each rotor, omega^2
  base::RotorVector weight;  ///< price of each rotor's share of `high`; equal: shared evenly
  std::vector<Servo> servos;
  base::Effectiveness hinge_B;  ///< of each servo: per omega^2 along the hinge, at any tilt

  /// Setup for a vehicle; all rotors have the same weight.
  /// @param lost  rotors that leave no wake to the one below
  static AllocationSetup of(const base::Vehicle& vehicle, RotorSet lost = 0);
};

/// Finds rotor speeds for thrust, moments and sideways force, for any number and place of rotors.
///
/// Three nested weighted pseudo-inverses, each computed once: of (U1, U2, U3); with U4; with the
/// forces along Dx and Dy, as far as the rotors give them independently. A pseudo-inverse minimises
/// the sum of weight (omega^2 / omega_max^2)^2 (T. A. Johansen and T. I. Fossen, "Control
/// allocation - A survey", Automatica 49, 2013, Sect. 2.2). A step applies them in order of
/// priority, each only as far as the limits allow:
///
///   1. roll and pitch, scaled together; thrust moves as far as they need, on the ground only down;
///   2. thrust, as near to the demand as the limits allow;
///   3. yaw, from the value that 1 and 2 happen to give towards the demand: it may be given up
///      wholly, even if the vehicle then turns against the demand; if another yaw leaves 1 and 2
///      more room, that one is taken. Where a rotor is lost, a second step without the rotor that
///      ends the first takes what is left of it (redistributed pseudo-inverse);
///   4. force sideways.
///
/// Scaling keeps directions and the order of priority, as W. C. Durham ("Constrained control
/// allocation", Journal of Guidance, Control, and Dynamics 16(4), 1993) asks for, but the set of
/// moments that a pseudo-inverse reaches is smaller than the set that the rotors can reach (M.
/// Bodson, "Evaluation of optimization methods for control allocation", same journal 25(4), 2002).
/// Speeds within the limits reach the demand exactly.
///
/// A lost rotor is left out. A hexarotor whose rotors turn in alternate directions cannot then
/// hover with yaw under control in both directions (G.-X. Du, Q. Quan, K.-Y. Cai, "Controllability
/// analysis and degraded control for a class of hexacopters subject to rotor failures", Journal of
/// Intelligent & Robotic Systems 78, 2015): the opposite rotor would have to push downwards.
/// Priority 3 makes it fly: full thrust, roll and pitch, yaw uncontrolled. No heap in allocate().
class ControlAllocation {
 public:
  /// @param lost  rotors to leave out
  explicit ControlAllocation(const AllocationSetup& setup, RotorSet lost = 0);

  /// @param may_lift  whether roll and pitch may raise the thrust above the demand (in the air)
  MixerResult allocate(const ControlDemand& demand, bool may_lift = true) const;
  /// All rotors at their slowest.
  MixerResult idle() const;

  /// How many of U1..U4 and the two sideways forces can be had independently, 0..6.
  int rank() const { return rank_; }
  bool has_yaw() const { return has_yaw_; }
  /// U4 that can be had beside `thrust_n` without rolling or pitching: the less of both senses, and
  /// the more. The less is negative where the rotors turn the vehicle one way whatever they do.
  struct YawReach {
    double less_nm = 0;
    double more_nm = 0;
  };
  YawReach yaw_reach(double thrust_n) const;
  /// Whether roll and pitch can go both ways while the rotors carry `thrust_n` without a moment.
  bool carries(double thrust_n) const;
  /// The most thrust without a moment, N.
  double max_thrust_n() const { return level_.to; }
  /// Force that can be had in each direction sideways beside `thrust_n`, without a moment, N.
  double side_force_n(double thrust_n) const;

 private:
  /// Thrusts from..to; empty when from > to.
  struct Range {
    double from = 0;
    double to = 0;
  };
  /// Rows: U1..U4, forces along Dx and Dy. Columns: rotors, then servos.
  using Matrix = base::Effectiveness;
  /// Columns for a few of the rows above.
  template <int columns>
  using Inverse =
      Eigen::Matrix<double, Eigen::Dynamic, columns, Eigen::ColMajor, base::kMaxRotors, columns>;

  void invert(const base::RotorVector& scale);
  void invert_without_each(const base::RotorVector& scale, RotorSet lost);
  void turn(double wanted_nm, base::RotorVector& x) const;
  Range thrust_range(const base::RotorVector& base) const;
  double largest_tilt(const base::RotorVector& tilt) const;
  double largest_part(const base::RotorVector& base, const base::RotorVector& step) const;
  base::RotorVector level_flight(const Eigen::Vector4d& u, bool may_lift) const;
  bool with_any_yaw(const base::RotorVector& tilt, const Eigen::Vector4d& u,
                    base::RotorVector& x) const;
  void hold_limits(base::RotorVector& x, MixerResult& result) const;

  Matrix wrench_D_;
  Matrix hinge_D_;  // columns: servos
  base::RotorVector low_, high_;
  std::vector<AllocationSetup::Servo> servos_;
  Inverse<3> lift_;  // of U1, U2, U3
  Inverse<1> turn_;  // of U4
  /// Inverse of U4 with one of the rotors as it is, for each rotor; only where a rotor is lost.
  std::vector<Inverse<1>> turn_without_;
  Inverse<2> side_;  // of the forces along Dx, Dy
  bool has_lift_ = false, has_yaw_ = false;
  bool lift_turns_ = false;  // thrust, roll and pitch alone would turn the vehicle
  std::array<bool, 2> has_side_{};
  int rank_ = 0;
  Range level_;  // thrusts without a moment
};

}  // namespace cas::fcu
