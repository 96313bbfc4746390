// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/outside_hands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "casd/packet/intervention.hpp"

namespace cas::hils {
namespace {

bool has_vehicle_do(const OutsideCall& call) {
  if (call.method.starts_with("vehicle.")) return is_act(call);
  if (call.method != "param.set") return false;
  const auto params = nlohmann::json::parse(call.params, nullptr, false);
  return !params.is_object() || casd::is_of_disarming(params.value("name", ""));
}

}  // namespace

std::optional<std::string> first_hand(const OutsideHands& hands) {
  const auto disarm = std::ranges::find_if(hands.calls, may_disarm);
  const auto call =
      disarm != hands.calls.end() ? disarm : std::ranges::find_if(hands.calls, has_vehicle_do);
  if (call != hands.calls.end() && (call == disarm || hands.acts.empty())) {
    const bool is_plain = call->method == "vehicle.disarm" || call->params == "{}";
    return fmt::format("{} called {}{}", call->client, call->method,
                       is_plain ? "" : " " + call->params);
  }
  if (hands.acts.empty()) return std::nullopt;
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

std::optional<std::string> arm_fault(const OutsideHands& hands) {
  if (std::ranges::any_of(hands.acts, &HeardAct::disarms) ||
      std::ranges::any_of(hands.calls, may_disarm)) {
    return fmt::format(
        "somebody disarmed the vehicle, or may have, before hils armed it ({}); hils does not arm "
        "it",
        *first_hand(hands));
  }
  if (hands.forgotten_calls > 0) return forgotten_words(hands) + "; hils does not arm it";
  return std::nullopt;
}

std::string hands_words(const OutsideHands& hands) {
  const auto who = first_hand(hands);
  return who ? " (" + *who + ")" : std::string();
}

}  // namespace cas::hils
