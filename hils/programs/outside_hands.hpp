// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/flight_changes.hpp"

namespace cas::hils {

/// Acts on the vehicle by others than hils: calls of casd's command port, and ground stations seen
/// by casd.
struct OutsideHands {
  std::vector<OutsideCall> calls{};
  std::vector<HeardAct> acts{};
  std::uint64_t forgotten_calls = 0;  ///< older ones, which casd does not know any more
  std::uint64_t acts_so_far = 0;      ///< what comes later than this keeps casd from arming
};

/// Why a vehicle is not armed: somebody has disarmed it, or tried to, or may have. Empty: no
/// objection.
std::string arm_fault(const OutsideHands& hands);

/// The most important call or act, those that disarm first: "unix:uid 1000 called vehicle.disarm".
/// Empty: there was none.
std::string first_hand(const OutsideHands& hands);
/// That casd does not know all calls any more, as a sentence.
std::string forgotten_words(const OutsideHands& hands);
/// " (255/190 on link gcs: command 400 (disarm))" for the message of a failed flight; empty: no act
/// of others.
std::string hands_words(const OutsideHands& hands);

}  // namespace cas::hils
