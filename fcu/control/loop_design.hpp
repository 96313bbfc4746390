// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <complex>

#include "base/config/vehicle.hpp"
#include "fcu/control/control_params.hpp"

namespace cas::fcu {

/// The open rate loop about one axis:
///
///   L(s) = k ((1 + i/s) F(s) + d s F(s) D(s)) / s * 1 / (lag s + 1) * exp(-delay s)
///
/// with the body as an integrator, the motors as a first-order lag, F and D the low-passes of the
/// gyro and of its derivative (Butterworth, second order). Sampling, tilt servos, gyroscopic
/// moments and the reaction of a rotor's acceleration are not modelled.
struct RateLoop {
  double gain_rad_s = 0;  ///< k: the crossover if the body were all; gain * full torque / inertia
  double i_per_p = 0;     ///< 1/s
  double d_per_p = 0;     ///< s
  double lag_s = 0;
  double delay_s = 0;  ///< from a sample of the gyro to a change at the motors
  double gyro_cutoff_hz = 0;
  double dgyro_cutoff_hz = 0;

  std::complex<double> at(double w_rad_s) const;
};

/// How far an open loop is from the edge of stability.
struct LoopMargins {
  double crossover_rad_s = 0;  ///< the highest at which |L| = 1
  double phase_rad = 0;        ///< of L above -180 degrees there
  double gain = 0;             ///< 1/|L| at the first frequency with a phase of -180 degrees
};
LoopMargins margins(const RateLoop& loop);

/// Least phase margin of a gain that is derived. A closed loop of second order has a damping ratio
/// of about a hundredth of its phase margin in degrees: 0.45, with which a step overshoots by 20 %.
inline constexpr double kPhaseMargin_rad = 45 * base::kRadPerDeg;

/// Delay of the usual bench, for which gains are derived: 921 600 baud each way (1.4 ms), a control
/// period of 2.5 ms, half of it on average, a step of the simulator and casd's hops.
inline constexpr double kUsualDelay_s = 0.005;

/// The gain of `usual`, or the largest below it that leaves kPhaseMargin_rad; its integrator is as
/// much slower.
double derived_gain_rad_s(const RateLoop& usual);

/// Lag of a vehicle's motors: the mean of speeding up and slowing down, of the slowest rotor.
double motor_lag_s(const base::Vehicle& vehicle);

/// Rate loops about Dx, Dy and Dz with the parameters that a controller flies.
std::array<RateLoop, 3> rate_loops(const base::Vehicle& vehicle, const ControlParams& params,
                                   double delay_s);

/// Gains and limits that depend on the airframe. Where the motors are quick, the rate loops about
/// roll and pitch have a gain of 20 rad/s, about yaw 7; slower ones get what leaves the phase
/// margin, and the loops of attitude, velocity and position are as much slower.
/// @return how much slower than usual roll and pitch are, 0..1
double derive_gains(const base::Vehicle& vehicle, ControlParams& params);

}  // namespace cas::fcu
