// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hils/programs/outside_hands.hpp"

namespace cas::hils {

/// Whether the vehicle was disarmed by its disarm step, or by its autopilot after landing.
/// @param gave_disarm  hils sent it, it was accepted, and nobody has armed the vehicle since
/// @param words  the vehicle's text on its newest disarming; empty: none
bool is_own_end(bool gave_disarm, std::string_view words);

/// Facts about a vehicle that hils armed, that did not take off and is now disarmed.
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
/// A vehicle that a person disarms stays disarmed. So the autopilot must be known as the cause:
/// nobody else commanded the vehicle, it never left the ground, and PX4 reports its
/// COM_DISARM_PRFLT ("auto preflight disarming"); ArduPilot gives no reason, so the time since the
/// arming must equal its DISARM_DELAY. An unknown cause counts as a person.
std::string rearm_fault(const Disarming& disarming);

}  // namespace cas::hils
