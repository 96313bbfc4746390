// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>

#include "base/enum_words.hpp"

namespace cas::hils {

/// Incidents that fail any flight, whatever its limits.
enum class IncidentKind {
  kGround,    ///< touched the ground in a step that is flown in the air
  kCrash,     ///< hit something faster than a landing
  kAttitude,  ///< tilted beyond 75 degrees
  kFlyaway,   ///< left ten times the extent of its flight
  kStrike,    ///< a rotor hit something and stopped
};
inline constexpr std::array kIncidentKinds{IncidentKind::kGround, IncidentKind::kCrash,
                                           IncidentKind::kAttitude, IncidentKind::kFlyaway,
                                           IncidentKind::kStrike};

/// The words in a scenario's `allow` and in summary.json.
inline constexpr base::EnumWords<IncidentKind::kStrike> kIncidentWords{
    "ground", "crash", "attitude", "flyaway", "strike"};
constexpr std::string_view to_string(IncidentKind kind) { return kIncidentWords[kind]; }

}  // namespace cas::hils
