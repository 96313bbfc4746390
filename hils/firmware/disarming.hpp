// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hils/programs/outside_hands.hpp"

namespace cas::hils {

/// Whether the disarming after a disarm step was that step's, or the autopilot's own after landing.
/// @param gave_disarm  hils did, it was accepted, and nobody has armed the vehicle since
/// @param words  what the vehicle said of its newest disarming; empty: nothing
bool is_own_end(bool gave_disarm, std::string_view words);

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

/// Why a vehicle is not armed again; nothing: its autopilot has disarmed itself on the ground.
///
/// What a person disarms stays disarmed. So it must be known that the autopilot did it: nobody else
/// had the vehicle do anything, it never left the ground, and PX4 says that this was its
/// COM_DISARM_PRFLT ("auto preflight disarming"); of ArduPilot, which gives no reason, the time
/// since the arming must be its DISARM_DELAY. What is not known counts as a person.
std::optional<std::string> rearm_fault(const Disarming& disarming);

}  // namespace cas::hils
