// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/trajectory.hpp"

namespace cas::hils {

/// Where the vehicle shall be at a moment of a step: the place of the last takeoff or goto, or the
/// point of the trajectory under way. North, east, up from the start; a trajectory is taken to have
/// begun when the vehicle confirmed it.
Pose reference_at(const Stage& stage, std::int64_t time_us);

}  // namespace cas::hils
