// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "libsim/api/world.hpp"

namespace cas::sim {

/// A vehicle in steady air, as it is asked for its trim.
struct Airframe {
  double mass_kg = 0;
  Eigen::Matrix3d inertia_B = Eigen::Matrix3d::Zero();  ///< kg m^2
  Environment air;                                      ///< gravity and density count
  std::size_t surfaces = 0;                             ///< control surfaces
  /// Force and moment by motion, deflections (rad) and throttle (0..1) in steady state: rotors turn
  /// as fast as they will in the end.
  std::function<Wrench(const BodyState& body, std::span<const double> deflections, double throttle)>
      wrench;
};

/// Straight and level flight.
struct Trim {
  double speed_m_s = 0;
  double alpha_rad = 0;  ///< angle of attack
  double beta_rad = 0;   ///< sideslip; 0 where a surface can hold it there
  double roll_rad = 0;
  double pitch_rad = 0;
  double throttle = 0;                  ///< may lie outside 0..1: more than there is
  std::vector<double> deflections_rad;  ///< the smallest that balance roll, pitch and yaw
};

/// Motion of a vehicle in the axes of D: u, v, w (m/s), p, q, r (rad/s), roll, pitch (rad).
using FlightState = Eigen::Matrix<double, 8, 1>;

/// Body at the origin with nose to the north, in that motion.
BodyState body_of(const FlightState& state);

/// Rates of change of the state, by Newton and Euler.
FlightState state_rates(const Airframe& airframe, const FlightState& state,
                        std::span<const double> deflections, double throttle);

/// State of a trim, at which state_rates() are 0.
FlightState state_of(const Trim& trim);

/// Trim of straight and level flight at an airspeed, by Newton's method with steps halved where
/// they do not help. Deflections are the pseudo-inverse's of the moments that the surfaces give.
/// @return nullopt where there is none: no thrust, or not enough lift
std::optional<Trim> level_trim(const Airframe& airframe, double speed_m_s);

}  // namespace cas::sim
