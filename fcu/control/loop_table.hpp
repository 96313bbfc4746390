// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "fcu/control/loop_design.hpp"

namespace cas::fcu {

/// Crossover, phase and gain margin of the rate loops about Dx, Dy and Dz, in lines for people,
/// with a warning where less than 30 degrees or 6 dB are left.
std::string loop_table(const std::array<RateLoop, 3>& loops);

}  // namespace cas::fcu
