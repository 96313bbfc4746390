// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "fcu/core/fcu_config.hpp"

namespace cas::fcu {

/// Delay from a sample of the gyro in the simulator to a change at its motors: both packets on the
/// controller's line, a control period, a step of the simulator and casd's hops (together 1.1 ms),
/// s.
double loop_delay_s(const FcuConfig& config);

/// Crossover, phase and gain margin of each rate loop of this controller as it would fly, in lines
/// for people, with a warning where less than 30 degrees or a factor of 2 are left.
std::string describe_controller(const FcuConfig& config);

}  // namespace cas::fcu
