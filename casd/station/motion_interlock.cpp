// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/motion_interlock.hpp"

#include <fmt/format.h>

namespace cas::casd {

std::optional<std::string> rival_words(const VehicleState& state, const VehicleTable& table,
                                       base::RunTime now) {
  const std::optional<Rival> rival = state.rival(now);
  if (!rival) return std::nullopt;
  return fmt::format(
      "{} is not alone: another autopilot with its system id ({}/{}) speaks on {}; give one of "
      "them another id, or, where both links lead to one vehicle, put them into one group",
      vehicle_text(state), rival->source.system, rival->source.component,
      table.place(state, *rival));
}

std::optional<std::string> not_in_hil(const VehicleState& state, base::RunTime now) {
  const base::Duration silence = state.heartbeat_age(now);
  if (silence > kVehicleTimeout) {
    return fmt::format(
        "{} has sent no HEARTBEAT for {} s, so casd cannot tell whether it is in HIL mode",
        vehicle_text(state), static_cast<int>(base::to_seconds(silence)));
  }
  if (!state.hil()) return vehicle_text(state) + " does not say that it is in HIL mode";
  if (state.denied_hil(now)) {
    return vehicle_text(state) + " said within the last 3 s that it is not in HIL mode";
  }
  return std::nullopt;
}

std::optional<Outcome> motion_interlock(Motion motion, const VehicleState& state,
                                        const VehicleTable& table, NotHilConsent consent,
                                        base::RunTime now) {
  const bool spins = motion == Motion::kSpins;
  if (!spins && (motion != Motion::kMoves || !state.armed())) return std::nullopt;
  // With two autopilots, consent does not say which one is meant.
  if (const auto rival = rival_words(state, table, now); rival && spins) {
    return failure(OutcomeKind::kInterlock, *rival);
  }
  if (consent.request && consent.configuration) return std::nullopt;
  std::optional<std::string> why = not_in_hil(state, now);
  if (!why) return std::nullopt;
  const bool silent = state.heartbeat_age(now) > kVehicleTimeout;
  if (!silent) {
    *why += spins ? ": real propellers may spin" : " and is armed: a real vehicle may move";
  }
  *why += silent ? "; look after its power and its link first (casctl doctor)"
          : consent.request
              ? "; --not-hil also needs commanding.allow_not_hil: true in casd's configuration"
              : "; put it in HIL mode (PX4: SYS_HITL 1 and a restart), or, for a firmware that "
                "runs in software and never says so, allow it: commanding.allow_not_hil: true "
                "and --not-hil";
  return failure(OutcomeKind::kInterlock, *why);
}

}  // namespace cas::casd
