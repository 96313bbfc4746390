// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/pilot.hpp"

#include <utility>

namespace cas::test {

casd::Done Pilot::then(Stage next) {
  return [this, next](const casd::Outcome& outcome) {
    if (!outcome.ok()) failure_ = outcome.message;
    enter(outcome.ok() ? next : Stage::kFailed, now_);
  };
}

void Pilot::tick(base::RunTime now) {
  now_ = now;
  commander_.tick(now);
  step(now);
  while (!queue_.empty()) {
    const std::vector<std::uint8_t> packet = std::move(queue_.front());
    queue_.pop_front();
    to_vehicle_(packet, {});
  }
}

void Pilot::step(base::RunTime now) {
  const casd::VehicleState* state = vehicle();
  if (state == nullptr) return;
  const auto altitude = state->altitude();
  switch (stage_) {
    case Stage::kWait:
      // A vehicle says by its refusal that it is not ready yet: ask again.
      if (now - since_ < kAskAgain) break;
      if (plan_.waits_for_position && !casd::position_lack(*state, now).empty()) break;
      enter(Stage::kArm, now);
      commander_.arm(kSystem, {.not_hil = plan_.not_hil}, now, [this](const casd::Outcome& armed) {
        if (!armed.ok()) refusals_.push_back(armed);
        enter(armed.ok() ? Stage::kTakeoff : Stage::kWait, now_);
      });
      break;
    case Stage::kTakeoff:
      enter(Stage::kArm, now);  // under way
      commander_.takeoff(kSystem, plan_.altitude_m, now, then(Stage::kClimb), plan_.not_hil);
      break;
    case Stage::kClimb:
      if (altitude && altitude->message > 0.9 * plan_.altitude_m) enter(Stage::kHover, now);
      break;
    case Stage::kHover:
      if (now - since_ < plan_.hover) break;
      hover_altitude_m_ = altitude ? altitude->message : 0;
      enter(Stage::kLand, now);
      commander_.land(kSystem, now, then(Stage::kDescend));
      break;
    case Stage::kDescend:
      if (!state->armed()) enter(Stage::kDone, now);
      break;
    case Stage::kArm:
    case Stage::kLand:
    case Stage::kDone:
    case Stage::kFailed:
      break;
  }
}

}  // namespace cas::test
