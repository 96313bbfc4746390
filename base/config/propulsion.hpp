// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/export.hpp"

namespace cas::base {

/// A propeller's coefficient f over its advance ratio J = V / (n D).
///
/// Between the rows of a table it is a monotone cubic (F. N. Fritsch, R. E. Carlson, "Monotone
/// piecewise cubic interpolation", SIAM J. Numer. Anal. 17, 1980), which has no kinks. Above the
/// last row it goes on along its tangent; a polynomial of degree two is the same with one row at J
/// = 0 and its square term beyond. Below the first row, and below 0 in any case, the air comes from
/// behind: the slope fades, so that f tends to a constant.
///
/// Forces go with n^2 f(u / n), u = V / D. In each of these ranges that is a homogeneous function
/// of degree two in (n, u), so it is finite and has a continuous gradient for all n >= 0 and all u,
/// a propeller that stands included.
class CAS_BASE_EXPORT PropellerCurve {
 public:
  PropellerCurve() = default;
  /// c0 + c1 J + c2 J^2 for J >= 0.
  static PropellerCurve polynomial(double c0, double c1, double c2);
  /// @param ratios  J, ascending; one at least
  /// @param values  f at each
  static PropellerCurve table(std::span<const double> ratios, std::span<const double> values);

  /// f(0): in still air.
  double at_rest() const { return at_rest_; }
  /// n^2 f(u / n).
  /// @param n  rev/s, not below 0
  /// @param u  axial airspeed over the diameter, 1/s
  double scaled(double n, double u) const;
  /// Whether f falls, or stays, where J grows without end: in fast air a propeller brakes.
  bool falls() const { return square_ < 0 || (square_ == 0 && nodes_.back().slope <= 0); }

 private:
  struct Node {
    double ratio = 0;
    double value = 0;
    double slope = 0;
  };
  void settle_ends();

  std::vector<Node> nodes_{Node{}};
  double square_ = 0;  // of the tail above the last node
  double fade_ = 1;    // of J below the first node, where f has gone half of its way
  double at_rest_ = 0;
};

/// A propeller by its coefficients: T = rho n^2 D^4 CT(J), Q = rho n^2 D^5 CQ(J), J = V / (n D).
/// One that turns the other way does the same in air that moves the other way. Edgewise flow,
/// Reynolds and Mach number are not modelled.
struct CAS_BASE_EXPORT Propeller {
  double diameter_m = 0;
  PropellerCurve thrust;  ///< CT
  PropellerCurve torque;  ///< CQ = CP / (2 pi)

  /// Along the axis, N.
  /// @param omega_rad_s  of the rotor
  /// @param axial_m_s    of the hub through the air, along the axis
  double thrust_n(double density_kg_m3, double omega_rad_s, double axial_m_s) const;
  /// Against its turning, with the sign of omega, N m; below 0 * omega the air drives it.
  double torque_nm(double density_kg_m3, double omega_rad_s, double axial_m_s) const;
};

/// A brushless motor and its speed controller as a direct-current circuit: i = (d V - K w) / R,
/// held at +-max_current_a, and the torque K (i - i_0), with K = 60 / (2 pi KV) both as the back
/// EMF's and the torque's constant. The controller passes the duty d on without loss and brakes,
/// too: a motor that turns faster than the duty asks feeds the battery. The winding's inductance,
/// iron losses that grow with speed, and heat are not modelled.
struct CAS_BASE_EXPORT ElectricMotor {
  double torque_constant_nm_a = 0;  ///< K, also in V s
  double resistance_ohm = 0;        ///< R: winding, controller and leads
  double no_load_current_a = 0;     ///< i_0: friction and iron
  double max_current_a = 0;         ///< the controller's limit, of either sign
  int esc_steps = 0;                ///< of the duty from 0 to 1; 0: any duty
  double supply_v = 0;              ///< full battery at rest, in which duties are planned

  /// Current at `voltage_v` = d V, A.
  double current_a(double voltage_v, double omega_rad_s) const;
  /// Torque at the shaft, N m. Friction changes its sign within 1 rad/s of standing.
  double torque_nm(double current_a, double omega_rad_s) const;
  /// Speed at which the motor holds a load of k_m w^2, rad/s; the load's speed at the current limit
  /// where that is lower, 0 where friction holds the rotor.
  /// @param duty  -1..1
  double steady_speed_rad_s(double duty, double torque_coefficient) const;
  /// Duty for a speed, -1..1: inverse of steady_speed_rad_s() at the full battery, without the
  /// current limit.
  double steady_duty(double omega_rad_s, double torque_coefficient) const;
  /// Time constant with a load of k_m w^2 for small changes about omega, s: J / (K^2 / R + 2 k_m
  /// w).
  double lag_s(double inertia_kg_m2, double torque_coefficient, double omega_rad_s) const;
  /// The duty in the controller's steps.
  double rounded(double duty) const;
};

/// A resistance with a capacitor beside it: V' = (R i - V) / tau.
struct RcPair {
  double resistance_ohm = 0;
  double time_constant_s = 1;
};

/// A battery whose voltage sags under load and falls with its charge: an open-circuit voltage
/// behind a resistance and two RC pairs (M. Chen, G. A. Rincon-Mora, "Accurate electrical battery
/// model capable of predicting runtime and I-V performance", IEEE Trans. Energy Convers. 21, 2006).
/// Temperature, ageing and self-discharge are not modelled.
struct CAS_BASE_EXPORT BatteryParams {
  /// Open-circuit voltage at a charge, 0..1.
  struct Point {
    double charge = 0;
    double voltage_v = 0;
  };
  double full_v = 0;           ///< at rest, charged
  double empty_v = 0;          ///< at rest, discharged
  double capacity_ah = 0;      ///< charge from full to empty
  double resistance_ohm = 0;   ///< inner resistance and leads
  double efficiency = 0;       ///< shaft power over electrical power, of rotors without a circuit
  std::vector<Point> curve{};  ///< from 0 to 1; empty: a straight line from empty_v to full_v
  std::array<RcPair, 2> rc_pairs{};  ///< of resistance 0 where there are none

  /// Open-circuit voltage, straight between the points.
  double open_v(double charge) const;
};

}  // namespace cas::base
