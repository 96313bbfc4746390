// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// When the vehicle passed the waypoints of a mission, in their order: coarsely, as below. One
/// above terrain counts by its place alone.
///
/// @param origin_m  where the vehicle took off: north, east, up
/// @param flown  in the mission
/// @return places in `flown`; fewer than waypoints when it did not come near one
std::vector<std::size_t> passings(std::span<const MissionPlace> places,
                                  const Eigen::Vector3d& origin_m,
                                  std::span<const PoseSample> flown);

/// Steps that the vehicle reports as done but that its true motion does not show: a place where it
/// was not (goto, takeoff, rtl), a waypoint of a mission that it did not come near, a trajectory in
/// which it hardly moved, a landing after which its rotors carry it on.
///
/// Places count from the vehicle's place at its last takeoff. The checks are coarse, so that an
/// estimate may be a little off; limits judge how well a step was flown.
///
/// @param stages  those that count as done, in their order
/// @param truth  in the order of time, to the end of the record
/// @return a sentence each, without a full stop
std::vector<std::string> steps_not_flown(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth);

}  // namespace cas::hils
