// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <complex>

#include "base/config/vehicle.hpp"
#include "fcu/control/control_params.hpp"

namespace cas::fcu {

/// The open rate loop about one axis:
///
///   L(s) = k ((1 + i/s) F(s) + d s F(s) D(s)) / s * (lead s + 1) / (lag s + 1) * exp(-delay s)
///
/// with the body as an integrator, the motors as a first-order lag, F and D the low-passes of the
/// gyro and of its derivative (Butterworth, second order). Sampling, tilt servos and gyroscopic
/// moments are not modelled.
struct RateLoop {
  double gain_rad_s = 0;  ///< k: the crossover if the body were all; gain * full torque / inertia
  double i_per_p = 0;     ///< 1/s
  double d_per_p = 0;     ///< s
  double lag_s = 0;
  double lead_s = 0;   ///< of yaw: an accelerated rotor turns the body before its drag does
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
/// Least gain margin of it: 6 dB.
inline constexpr double kGainMargin = 2;

/// Least delay for which gains are derived, that of the usual bench: 921 600 baud each way (1.4
/// ms), a control period of 2.5 ms, a step of the simulator and casd's hops.
inline constexpr double kUsualDelay_s = 0.005;

/// The gain of `usual`, or the largest below it that leaves both margins; its integrator is as much
/// slower. Loop shaping: the crossover lies where motors, filters and delay still leave the
/// phase (K. J. Astrom and R. M. Murray, "Feedback Systems", Princeton 2008, Sect. 11.4).
double derived_gain_rad_s(const RateLoop& usual);

/// Lag of a vehicle's motors: the mean of speeding up and slowing down, of the slowest rotor.
double motor_lag_s(const base::Vehicle& vehicle);

/// RateLoop::lead_s of a vehicle in hover. A rotor with a yaw moment of c w^2 and an inertia J
/// yaws the body by 2 c w dw + J dw/dt: J / (2 c w). 0 with tilt servos, which yaw instead.
double yaw_lead_s(const base::Vehicle& vehicle);

/// Rate loops about Dx, Dy and Dz with the parameters that a controller flies. The gain about an
/// axis that the rotors do not turn is 0.
std::array<RateLoop, 3> rate_loops(const base::Vehicle& vehicle, const ControlParams& params,
                                   double delay_s);

/// Gains and limits that depend on the airframe. Where motors and line are quick, the rate loops
/// about roll and pitch have a gain of 20 rad/s, about yaw 7; slower ones get what leaves the
/// margins. The outer loops keep their ratios to it: attitude has 0.35 of the gain about roll and
/// pitch, velocity 0.2, position 0.075; the heading has 0.4 of that about yaw.
/// @param delay_s  from a sample of the gyro to a change at the motors
/// @return how much slower than usual roll and pitch are, 0..1
double derive_gains(const base::Vehicle& vehicle, double delay_s, ControlParams& params);

}  // namespace cas::fcu
