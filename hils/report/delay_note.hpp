// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/measure/measurement.hpp"

namespace cas::hils {

/// Whether a delay from end to end, or an age, is shown with a minus sign.
bool has_negative_delay(const Measurement& figures);
/// Whether the delay of a hop is.
bool has_negative_hop(const Measurement& figures);

/// Why there are such delays.
inline constexpr const char* kNegativeDelayNote =
    "A negative delay is none: the packet took less time than the moments are known to. casd notes "
    "a "
    "packet as sent when its write has returned, and the receiver may have it before that; the "
    "kernel's stamps of arrival are converted from the wall clock.";

}  // namespace cas::hils
