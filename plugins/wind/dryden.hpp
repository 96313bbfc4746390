// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "base/random.hpp"

namespace cas::sim {

inline constexpr double kMetresPerSecondPerKnot = 0.514444;

/// Lengths and intensities of turbulence, MIL-F-8785C.
///
/// Up to 1000 ft those of Sect. 3.7.3.4; from 2000 ft on those of Sect. 3.7.2: 1750 ft in all
/// directions, and the intensity of Figure 7 for the turbulence that is exceeded with a probability
/// of 1e-2 (light), 1e-3 (moderate) or 1e-5 (severe), which depends on the height alone. Between
/// them all four go linearly with height.
struct DrydenScales {
  double length_horizontal_m = 0;   ///< L_u = L_v
  double length_vertical_m = 0;     ///< L_w
  double sigma_horizontal_m_s = 0;  ///< sigma_u = sigma_v
  double sigma_vertical_m_s = 0;    ///< sigma_w

  /// @param w20_m_s   wind at 20 ft: 7.7 light, 15.4 moderate, 23.1 severe; between them, and
  /// beyond,
  ///                  Figure 7 is taken linearly
  /// @param height_m  above ground; 10 ft below that
  static DrydenScales at(double w20_m_s, double height_m);
};

/// Intensity of Figure 7 of MIL-F-8785C, in its figures between its heights, linear.
/// @param w20_m_s  as in DrydenScales::at()
double high_altitude_sigma_m_s(double w20_m_s, double height_m);

/// A filter (1 + c tau s) / (1 + tau s)^2 on white noise, stepped by its exact solution. Its output
/// has variance 1 and, with c = sqrt(3), the lateral and vertical spectrum of Dryden.
class DrydenLateral {
 public:
  void settle(base::NormalRandom& random);
  /// @param theta  step over time constant, V dt / L
  double advance(double theta, base::NormalRandom& random);

 private:
  double y1_ = 0;  // first-order filter of the noise, variance 1
  double y2_ = 0;  // the same filter once more
};

/// Dryden turbulence as a vehicle meets it: u along the wind, v across, w up.
///
/// The field is frozen and swept past at speed V, so it is a function of time with time constants
/// L / V. Each step takes the exact solution for its own V and height: nothing depends on the step.
class Dryden {
 public:
  Dryden() = default;
  explicit Dryden(std::uint64_t seed);

  /// @param speed_m_s  V, through the mean air; above zero
  /// @return (u, v, w), m/s
  Eigen::Vector3d advance(const DrydenScales& scales, double speed_m_s, double dt);

 private:
  base::NormalRandom random_;
  double u_ = 0;  // variance 1
  DrydenLateral v_;
  DrydenLateral w_;
};

/// How Dryden turbulence changes over a vehicle: the gusts p, q, r of MIL-F-8785C, which turn it.
///
/// q and r are the changes of w and v along the flow, which moves past with the speed V: time
/// derivatives over -V, with a lag of 4 b / (pi V) and 3 b / (pi V) for the span b of the vehicle,
/// over which they are averaged. p, of w across the flow, has the spectrum
/// sigma_w^2 / (V L_w) 0.8 (pi L_w / 4 b)^(1/3) / (1 + (4 b omega / (pi V))^2), which counts from 0
/// to infinity.
class DrydenRates {
 public:
  DrydenRates() = default;
  DrydenRates(double span_m, std::uint64_t seed);

  /// @param uvw  of Dryden::advance() for the same step
  /// @return change of (u, v, w) along its own axes, 1/s: row by component, column by direction
  Eigen::Matrix3d advance(const DrydenScales& scales, double speed_m_s, double dt,
                          const Eigen::Vector3d& uvw);

  /// Standing deviation of p, 1/s.
  static double sigma_p(const DrydenScales& scales, double span_m);

 private:
  double span_m_ = 0;
  base::NormalRandom random_;
  double p_ = 0;                                   // variance 1
  Eigen::Vector3d uvw_ = Eigen::Vector3d::Zero();  // of the step before
  double v_ = 0;                                   // lagging
  double w_ = 0;
  bool begun_ = false;
};

}  // namespace cas::sim
