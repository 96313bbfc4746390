// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "plugins/aero/trim.hpp"

namespace cas::sim {

/// A way in which a vehicle comes back to its trim, or leaves it; throttle and deflections held.
struct FlightMode {
  std::string name;                 ///< "phugoid"; "pitch mode" where it is none of the usual five
  std::complex<double> eigenvalue;  ///< 1/s; of a pair the one with positive imaginary part

  double frequency_rad_s() const { return std::abs(eigenvalue); }  ///< undamped
  double damping() const { return -eigenvalue.real() / std::abs(eigenvalue); }
  bool oscillates() const { return eigenvalue.imag() != 0; }
};

/// Eigenvalues of the motion about a trim, linearised by central differences: of (u, w, q, pitch)
/// short period and phugoid, of (v, p, r, roll) roll, Dutch roll and spiral.
std::vector<FlightMode> flight_modes(const Airframe& airframe, const Trim& trim);

}  // namespace cas::sim
