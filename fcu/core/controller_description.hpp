// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "fcu/core/fcu_config.hpp"

namespace cas::fcu {

/// Delay from a sample of the gyro in the simulator to a change at its motors: both packets on the
/// controller's line, a control period, a step of the simulator and casd's hops (together 1.1 ms),
/// s.
double loop_delay_s(const FcuConfig& config);

/// The part of it that a controller knows, for which it derives its default gains: by baud rate and
/// control rate, without extra_delay, jitter and batches of the line; kUsualDelay_s at least.
double design_delay_s(const FcuConfig& config);

/// The rate loops of this controller as it would fly: loop_table().
std::string describe_controller(const FcuConfig& config);

}  // namespace cas::fcu
