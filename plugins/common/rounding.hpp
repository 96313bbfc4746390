// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace cas::sim {

/// Rounded to six decimals: times and voltages as the figures of a run show them.
inline double six_decimals(double value) { return std::round(value * 1e6) / 1e6; }

}  // namespace cas::sim
