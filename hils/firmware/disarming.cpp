// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/disarming.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace cas::hils {
namespace {

/// Higher than a landing gear springs, lower than any takeoff of a scenario.
constexpr double kOnGround_m = 0.3;
/// HEARTBEATs show arming and disarming each up to a second late, hils looks each 50 ms of real
/// time.
constexpr double kEarly_s = 1.5;
constexpr double kLate_s = 3;

constexpr const char* kStays = "; hils does not arm it again";

bool has_vehicle_do(const OutsideCall& call) {
  return call.method.starts_with("vehicle.") && is_act(call);
}

/// The call or act that counts most: one that disarms before all others.
std::string first_hand(const OutsideHands& hands) {
  const auto disarm = std::ranges::find(hands.calls, "vehicle.disarm", &OutsideCall::method);
  const auto call =
      disarm != hands.calls.end() ? disarm : std::ranges::find_if(hands.calls, has_vehicle_do);
  if (call != hands.calls.end() && (call == disarm || hands.acts.empty())) {
    return fmt::format("{} called {}", call->client, call->method);
  }
  if (hands.acts.empty()) return {};
  const auto stop = std::ranges::find_if(hands.acts, &HeardAct::disarms);
  const HeardAct& act = stop == hands.acts.end() ? hands.acts.front() : *stop;
  return fmt::format("{}: {}", act.by, act.what);
}

/// How the disarming went by the vehicle itself; empty: it was its own.
std::string doubt(const Disarming& disarming) {
  if (!disarming.words.empty()) {
    const bool its_own = disarming.words.ends_with("auto preflight disarming");
    return its_own ? std::string() : fmt::format("it says \"{}\"", disarming.words);
  }
  if (disarming.autopilot != "ArduPilot") return "it does not say that it did so itself";
  if (!disarming.delay_s) return "it does not tell its DISARM_DELAY";
  const double early_s = disarming.armed_s.value_or(0) - *disarming.delay_s;
  if (disarming.armed_s && *disarming.delay_s > 0 && early_s > -kEarly_s && early_s < kLate_s) {
    return {};
  }
  return fmt::format("its own DISARM_DELAY is {:.0f} s, and it was armed for {:.1f} s",
                     *disarming.delay_s, disarming.armed_s.value_or(0));
}

}  // namespace

std::string arm_fault(const OutsideHands& hands) {
  const bool disarmed = std::ranges::any_of(hands.acts, &HeardAct::disarms) ||
                        std::ranges::any_of(hands.calls, [](const OutsideCall& call) {
                          return call.method == "vehicle.disarm";
                        });
  if (!disarmed) return {};
  return fmt::format(
      "somebody disarmed the vehicle before hils armed it ({}); hils does not arm it",
      first_hand(hands));
}

std::string rearm_fault(const Disarming& disarming) {
  if (const std::string who = first_hand(disarming.hands); !who.empty()) {
    return fmt::format("the vehicle was disarmed from outside ({}){}", who, kStays);
  }
  if (disarming.highest_m > kOnGround_m) {
    return fmt::format("the vehicle was disarmed after it had been {:.1f} m above the ground{}",
                       disarming.highest_m, kStays);
  }
  if (const std::string why = doubt(disarming); !why.empty()) {
    return fmt::format("the vehicle was disarmed, perhaps by a person: {}{}", why, kStays);
  }
  if (disarming.armed_again >= kMostRearmings) {
    return fmt::format("the vehicle has disarmed itself {} times before it took off{}",
                       disarming.armed_again + 1, kStays);
  }
  return {};
}

std::string hands_words(const OutsideHands& hands) {
  const std::string who = first_hand(hands);
  return who.empty() ? std::string() : " (" + who + ")";
}

}  // namespace cas::hils
