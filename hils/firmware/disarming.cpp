// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/disarming.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "casd/packet/intervention.hpp"

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
  if (call.method.starts_with("vehicle.")) return is_act(call);
  if (call.method != "param.set") return false;
  const auto params = nlohmann::json::parse(call.params, nullptr, false);
  return !params.is_object() || casd::is_of_disarming(params.value("name", ""));
}

/// The call or act that counts most: one that disarms before all others.
std::string first_hand(const OutsideHands& hands) {
  const auto disarm = std::ranges::find_if(hands.calls, may_disarm);
  const auto call =
      disarm != hands.calls.end() ? disarm : std::ranges::find_if(hands.calls, has_vehicle_do);
  if (call != hands.calls.end() && (call == disarm || hands.acts.empty())) {
    const bool is_plain = call->method == "vehicle.disarm" || call->params == "{}";
    return fmt::format("{} called {}{}", call->client, call->method,
                       is_plain ? "" : " " + call->params);
  }
  if (hands.acts.empty()) return {};
  const auto stop = std::ranges::find_if(hands.acts, &HeardAct::disarms);
  const HeardAct& act = stop == hands.acts.end() ? hands.acts.front() : *stop;
  return fmt::format("{}: {}", act.by, act.what);
}

std::string forgotten_words(const OutsideHands& hands) {
  return fmt::format(
      "casd has forgotten {} calls of its command port, so it is not known whether "
      "somebody disarmed the vehicle",
      hands.forgotten_calls);
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
  if (std::ranges::any_of(hands.acts, &HeardAct::disarms) ||
      std::ranges::any_of(hands.calls, may_disarm)) {
    return fmt::format(
        "somebody disarmed the vehicle, or may have, before hils armed it ({}); hils does not arm "
        "it",
        first_hand(hands));
  }
  if (hands.forgotten_calls > 0) return forgotten_words(hands) + "; hils does not arm it";
  return {};
}

std::string rearm_fault(const Disarming& disarming) {
  if (const std::string who = first_hand(disarming.hands); !who.empty()) {
    return fmt::format("the vehicle was disarmed from outside ({}){}", who, kStays);
  }
  if (disarming.hands.forgotten_calls > 0) return forgotten_words(disarming.hands) + kStays;
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
