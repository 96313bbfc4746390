// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::fcu {

/// Whether an actuator further down can follow no more in a direction.
struct Saturation {
  bool up = false;
  bool down = false;
};

/// Compares the demand with the value that an allocation achieved.
/// @param scale  full scale: a millionth of it counts as achieved
inline Saturation saturation_of(double wanted, double achieved, double scale) {
  const double tolerance = 1e-6 * scale;
  return {.up = achieved<wanted - tolerance, .down = achieved> wanted + tolerance};
}

}  // namespace cas::fcu
