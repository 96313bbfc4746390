// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hils/programs/outside_hands.hpp"

namespace cas::hils {

/// Whether the disarming after a disarm step was that step's, or the autopilot's own after landing.
/// @param gave_disarm  hils disarmed, the vehicle accepted, and it was not armed since
/// @param words  text of the vehicle on its newest disarming; empty: none
bool is_own_end(bool gave_disarm, std::string_view words);

/// Facts on a vehicle that hils armed and that was disarmed before it took off.
struct Disarming {
  OutsideHands hands{};             ///< since the run began
  std::string autopilot{};          ///< "PX4", "ArduPilot", "other"
  std::string words{};              ///< its text on it; empty: none
  std::optional<double> armed_s{};  ///< it was armed for so long, simulated
  std::optional<double> delay_s{};  ///< ArduPilot's DISARM_DELAY; nullopt: unknown
  double highest_m = 0;             ///< true height above its place on the ground so far
  int armed_again = 0;              ///< how often hils has armed it again by now
};

/// Most times that hils arms a vehicle again.
inline constexpr int kMostRearmings = 2;

/// Why a vehicle is not armed again; nullopt: its autopilot disarmed itself on the ground.
///
/// A vehicle that a person disarms stays disarmed. So it must be certain that the autopilot did it:
/// no other operator sent a command, the vehicle never left the ground, and PX4 says that this was
/// its COM_DISARM_PRFLT ("auto preflight disarming"); of ArduPilot, which gives no reason, the time
/// since the arming must be its DISARM_DELAY. In doubt it was a person.
std::optional<std::string> rearm_fault(const Disarming& disarming);

}  // namespace cas::hils
