// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/config.hpp"

namespace cas::hils {

/// What a step of a flight asks for.
enum class StepKind {
  kArm,      ///< done when the vehicle says that it is armed
  kTakeoff,  ///< done when it hangs still at the height
  kGoto,     ///< done when it hangs still at the place
  kHold,     ///< done when `duration` of simulated time has passed
  kSetGain,  ///< done when the vehicle has confirmed the gains
  kLand,     ///< done when the vehicle says that it stands on the ground
  kDisarm,   ///< done when it says that it is disarmed
};

std::string_view to_string(StepKind kind);

/// One step of a flight. Positions are in N with height up, relative to where the vehicle was
/// armed.
struct FlightStep {
  StepKind kind = StepKind::kHold;
  base::Duration timeout = std::chrono::seconds(30);  ///< simulated time until the step has failed
  double altitude_m = 0;                              ///< takeoff
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  ///< goto: north, east, up
  double yaw_rad = 0;                                 ///< goto
  base::Duration duration{};                          ///< hold
  bool measure = false;                               ///< hold: the window of all figures
  std::string loop{};                                 ///< setgain
  std::optional<double> p{}, i{}, d{};                ///< setgain
};

/// Reads the list `steps`: each entry is a word (`arm`) or a map with one key (`takeoff:
/// {altitude_m: 2.5}`). Checks that the flight is possible: armed before takeoff, exactly one
/// measured hold, landed at the end. @throws base::ConfigError
std::vector<FlightStep> parse_flight(const base::ConfigNode& steps);

}  // namespace cas::hils
