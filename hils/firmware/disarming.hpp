// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/flight_changes.hpp"

namespace cas::hils {

/// What others than hils had the vehicle do: calls of casd's command port, and what casd heard of
/// ground stations.
struct OutsideHands {
  std::vector<OutsideCall> calls{};
  std::vector<HeardAct> acts{};
  std::uint64_t forgotten_calls = 0;  ///< older ones, which casd does not know any more
};

/// Why a vehicle is not armed for the first time: somebody has disarmed it, or tried to, or may
/// have. Empty: nobody has.
std::string arm_fault(const OutsideHands& hands);

/// What is known of a vehicle that hils armed, that has not taken off and is armed no more.
struct Disarming {
  OutsideHands hands{};             ///< since the run began
  std::string autopilot{};          ///< "PX4", "ArduPilot", "other"
  std::string words{};              ///< what it said of it; empty: nothing
  std::optional<double> armed_s{};  ///< it was armed for so long, simulated
  std::optional<double> delay_s{};  ///< ArduPilot's DISARM_DELAY; nothing: it did not tell
  double highest_m = 0;             ///< true height above its place on the ground so far
  int armed_again = 0;              ///< how often hils has armed it again by now
};

/// Most times that hils arms a vehicle again.
inline constexpr int kMostRearmings = 2;

/// Why a vehicle is not armed again; empty: its autopilot has disarmed itself on the ground.
///
/// What a person disarms stays disarmed. So it must be known that the autopilot did it: nobody else
/// had the vehicle do anything, it never left the ground, and PX4 says that this was its
/// COM_DISARM_PRFLT ("auto preflight disarming"); of ArduPilot, which gives no reason, the time
/// since the arming must be its DISARM_DELAY. What is not known counts as a person.
std::string rearm_fault(const Disarming& disarming);

/// " (255/190 on link gcs: command 400 (disarm))" for the sentence of a flight that failed; empty:
/// nobody else had a hand in it.
std::string hands_words(const OutsideHands& hands);

}  // namespace cas::hils
