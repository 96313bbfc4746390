// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/control/wing_params.hpp"

namespace cas::fcu {

/// How a vehicle can fly.
enum class AirframeKind : std::uint8_t {
  kMulticopter,
  kPlane,  ///< a wing, and rotors that push forwards alone
  kVtol,   ///< a wing, rotors that push forwards, and others that lift
};

/// A vehicle without wing, or without a rotor along Bx, is a multicopter.
AirframeKind airframe_kind(const base::Vehicle& vehicle);
/// Indices of the rotors that push forwards.
std::vector<std::size_t> pushing_rotors(const base::Vehicle& vehicle);
/// The vehicle with those rotors alone that lift it, and with the full scales of these.
base::Vehicle lifting_part(const base::Vehicle& vehicle);

/// Linear aerodynamics about the centre of gravity, each over the dynamic pressure (Pa). Axes of D.
/// Stall, drag and sideslip are left out.
struct WingFigures {
  double lift_slope_m2 = 0;   ///< lift per rad of angle of attack
  double zero_lift_rad = 0;   ///< angle of attack without lift
  double stiffness_m3 = 0;    ///< pitching moment per rad of angle of attack, nose down
  double moment_zero_m3 = 0;  ///< pitching moment at an angle of attack of 0, nose up
  Eigen::Vector3d damping_m4 = Eigen::Vector3d::Zero();  ///< moment against rate over airspeed
  /// Moments (m^3) of the surfaces at output 1 about Dx, Dy, Dz, one column for each.
  Eigen::Matrix3Xd surface_moment_m3;
  Eigen::VectorXd surface_lift_m2;  ///< size of their lift at output 1

  static WingFigures of(const base::AeroParams& aero);
  /// Moments about Dx, Dy, Dz of those surfaces together that give at least half as much as the
  /// strongest, m^3: a demand of 1.
  Eigen::Vector3d full_moment_m3() const;
  /// Angle of attack whose lift carries `weight_n` at a dynamic pressure, rad.
  double angle_of_attack_rad(double weight_n, double pressure_pa) const {
    return zero_lift_rad + weight_n / (pressure_pa * lift_slope_m2);
  }
};

/// Share of full_moment_m3() that balances the pitching moment at an angle of attack.
double trim_demand(const WingFigures& figures, double alpha_rad);

/// Thrust of the rotors that push forwards at full throttle and an airspeed, N. It fades as the
/// vehicle file says; of a propeller by advance ratio half is taken to be left.
double forward_thrust_n(const base::Vehicle& vehicle, double airspeed_m_s);

/// Gains and limits that depend on the airframe. Feed-forward of a rate is its deflection in steady
/// state; the gains make roll and pitch rates follow with some 8 rad/s, and damp yaw by 3 1/s.
/// Speeds are shares of the cruise speed, throttles follow from the static thrust and a usual
/// glide ratio.
void derive_wing(const base::Vehicle& vehicle, WingParams& params);

}  // namespace cas::fcu
