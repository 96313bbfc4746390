// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/disarming.hpp"

#include <fmt/format.h>

namespace cas::hils {
namespace {

/// Higher than a landing gear springs, lower than any takeoff of a scenario.
constexpr double kOnGround_m = 0.3;
/// HEARTBEATs show arming and disarming each up to a second late, hils looks each 50 ms of real
/// time.
constexpr double kEarly_s = 1.5;
constexpr double kLate_s = 3;

constexpr const char* kStays = "; hils does not arm it again";

/// How the disarming went by the vehicle itself; nullopt: it was its own.
std::optional<std::string> doubt(const Disarming& disarming) {
  if (!disarming.words.empty()) {
    if (disarming.words.ends_with("auto preflight disarming")) return std::nullopt;
    return fmt::format("it says \"{}\"", disarming.words);
  }
  if (disarming.autopilot != "ArduPilot") return "it does not say that it did so itself";
  if (!disarming.delay_s) return "it does not tell its DISARM_DELAY";
  const double early_s = disarming.armed_s.value_or(0) - *disarming.delay_s;
  if (disarming.armed_s && *disarming.delay_s > 0 && early_s > -kEarly_s && early_s < kLate_s) {
    return std::nullopt;
  }
  return fmt::format("its own DISARM_DELAY is {:.0f} s, and it was armed for {:.1f} s",
                     *disarming.delay_s, disarming.armed_s.value_or(0));
}

}  // namespace

bool is_own_end(bool gave_disarm, std::string_view words) {
  if (words.ends_with("by landing")) return true;
  // The second is PX4 v1.11's.
  const bool by_command =
      words.ends_with("by external command") || words.ends_with("by Arm/Disarm component command");
  return gave_disarm && (words.empty() || by_command);
}

std::optional<std::string> rearm_fault(const Disarming& disarming) {
  if (const auto who = first_hand(disarming.hands)) {
    return fmt::format("the vehicle was disarmed from outside ({}){}", *who, kStays);
  }
  if (disarming.hands.forgotten_calls > 0) return forgotten_words(disarming.hands) + kStays;
  if (disarming.highest_m > kOnGround_m) {
    return fmt::format("the vehicle was disarmed after it had been {:.1f} m above the ground{}",
                       disarming.highest_m, kStays);
  }
  if (const auto why = doubt(disarming)) {
    return fmt::format("the vehicle was disarmed, perhaps by a person: {}{}", *why, kStays);
  }
  if (disarming.armed_again >= kMostRearmings) {
    return fmt::format("the vehicle has disarmed itself {} times before it took off{}",
                       disarming.armed_again + 1, kStays);
  }
  return std::nullopt;
}

}  // namespace cas::hils
