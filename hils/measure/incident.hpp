// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/flight/incident_kind.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// A landing of PX4 comes down at 0.7 m/s (MPC_LAND_SPEED); landing gear of this size takes 1 to 2.
/// For a plane that rolls on the ground the vertical speed counts.
inline constexpr double kCrashSpeed_m_s = 3.0;
/// Beyond it little lift is left (cos 75 degrees = 0.26), and no step asks for it: controllers are
/// limited to 45 (MPC_TILTMAX_AIR).
inline constexpr double kMostTilt_deg = 75.0;
/// The extent is the farthest place of the plan from the start, at least 1 m.
inline constexpr double kFarthestExtents = 10.0;
/// A faster rotor counts as turning: half the speed of idling rotors.
inline constexpr double kTurning_rad_s = 50.0;

/// Angle between the vehicle's axis and the vertical.
double tilt_deg(const Pose& pose);

/// Something that went wrong with the vehicle in a flight, by the true motion.
struct Incident {
  IncidentKind kind{};
  double time_s = 0;  ///< simulated
  std::string what;   ///< a sentence without a full stop
};

/// The first incident of each kind in a flight, from its first step to the end of the record.
/// Ground is the height of the vehicle at the start: over terrain only kCrash detects a touch.
///
/// @param stages  the flight as it went
/// @param truth   in the order of time
/// @param from_s  earlier samples are left out
std::vector<Incident> find_incidents(const std::vector<Stage>& stages,
                                     std::span<const PoseSample> truth, double from_s = 0);

}  // namespace cas::hils
