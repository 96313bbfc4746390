// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/flight_changes.hpp"

namespace cas::hils {

/// Commands of others than hils to the vehicle: calls of casd's command port, and packets of ground
/// stations that casd saw.
struct OutsideHands {
  std::vector<OutsideCall> calls{};
  std::vector<HeardAct> acts{};
  std::uint64_t forgotten_calls = 0;  ///< older ones, which casd does not know any more
  std::uint64_t acts_so_far = 0;      ///< later acts keep casd from arming
};

/// Why a vehicle is not armed: another operator has disarmed it, or tried to, or may have.
std::optional<std::string> arm_fault(const OutsideHands& hands);

/// The call or act that counts most, one that disarms before all others: "unix:uid 1000 called
/// vehicle.disarm". nullopt: there was no outside call or act.
std::optional<std::string> first_hand(const OutsideHands& hands);
/// That casd does not know all calls any more, as a sentence.
std::string forgotten_words(const OutsideHands& hands);
/// " (255/190 on link gcs: command 400 (disarm))" for the sentence of a flight that failed; empty:
/// there was no outside call or act.
std::string hands_words(const OutsideHands& hands);

}  // namespace cas::hils
