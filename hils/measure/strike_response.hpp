// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>

#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/flight/incident_kind.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/measure/vehicle_messages.hpp"

namespace cas::hils {

struct RunRecord;

/// Response of a vehicle to the first fault of a flight. Later times count from strike_s.
struct StrikeResponse {
  double strike_s = 0;                      ///< simulated
  std::string fault{};                      ///< its name
  std::optional<std::string> no_verdict{};  ///< why it cannot be judged; nullopt: it can
  bool armed_before = false;                ///< when it struck
  bool armed_after = false;                 ///< at some moment from then on
  bool tried_to_arm = false;                ///< by a step of the plan, from then on
  bool in_air = false;                      ///< at some moment from then on
  bool left_world = false;                  ///< its true motion was no number any more
  std::optional<double> detected_s{};       ///< first sign in the vehicle's messages
  std::string detected_by{};
  std::optional<double> reacted_s{};       ///< first mode that a failsafe chose, or rotors stopped
  std::string reaction{};                  ///< that mode: "LAND", "RTL", "terminated"
  bool terminated = false;                 ///< the vehicle stopped its rotors itself; of faults
                                           ///< of rotors or the battery: it said so
  bool completed = false;                  ///< the flight was flown to its end
  std::optional<IncidentKind> incident{};  ///< the first one from then on
  bool crashed = false;  ///< it hit something, turned over, flew away or fell at the end
  bool at_rest = false;  ///< at the end of the record, on the ground
  double rest_m = 0;     ///< then: horizontally from the place where it was struck
  /// From the place of the step in a hold, else from the lines between the places of the plan;
  /// infinite when its true motion was no number.
  double farthest_m = 0;
  double peak_tilt_deg = 0;  ///< before it hit or touched something
  /// Farthest distance and largest tilt within the hold that the fault struck, the distance from
  /// the place of the strike; nullopt: it struck in no hold.
  std::optional<double> hold_farthest_m{};
  std::optional<double> hold_tilt_deg{};
};

/// Evidence that the response is derived from.
struct StrikeEvidence {
  double strike_s = 0;
  std::optional<double> end_s{};  ///< of the fault; nullopt: it lasts to the end
  std::string fault{};
  bool stops_rotors = false;  ///< the fault does, by physics: standing rotors are no answer to it
  std::span<const Stage> stages{};  ///< with the one that was under way at the end
  std::span<const FlightStep> steps{};
  bool completed = false;
  std::span<const PoseSample> truth{};
  VehicleMessages messages{};
};
/// Signs count until the first impact, or one HEARTBEAT after the fault's end, or the end of the
/// flight: of its last step, or disarmed on the ground; of a strike on the ground after that, too.
StrikeResponse strike_response(const StrikeEvidence& evidence);

/// The response to the first fault of a flight; nullopt when none struck.
/// @param steps   of the vehicle
/// @param faults  that its plugin plays
std::optional<StrikeResponse> read_strike_response(const RunRecord& record,
                                                   std::span<const FlightStep> steps,
                                                   std::span<const VehicleFault> faults,
                                                   std::span<const PoseSample> truth);

}  // namespace cas::hils
