// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/flight_rehearsal.hpp"

#include <string>

namespace cas::hils {

void FlightRehearsal::play(const FlightStep& step, const base::ConfigNode& node) {
  const std::string word(to_string(step.kind));
  switch (step.kind) {
    case StepKind::kArm:
      if (armed_) refuse(node, "the vehicle is armed already");
      armed_ = true;
      return;
    case StepKind::kTakeoff:
      if (!armed_) refuse(node, "takeoff needs an arm step before it");
      if (airborne_) refuse(node, "the vehicle is in the air already");
      airborne_ = true;
      return;
    case StepKind::kGoto:
    case StepKind::kTrajectory:
    case StepKind::kLand:
      if (!airborne_) refuse(node, word + " needs a takeoff step before it");
      airborne_ = step.kind != StepKind::kLand;
      return play_measure(step, node);
    case StepKind::kHold:
    case StepKind::kStandBy:
      return play_measure(step, node);
    case StepKind::kDisarm:
      if (airborne_) refuse(node, "disarm in the air would drop the vehicle: land first");
      armed_ = false;
      return;
    case StepKind::kEndTrajectory:
    case StepKind::kSetGain:
    case StepKind::kSetParam:
    case StepKind::kWaitUntil:
      return;
  }
}

void FlightRehearsal::play_measure(const FlightStep& step, const base::ConfigNode& node) {
  if (!step.measure) return;
  if (!airborne_) refuse(node, "a measured hold needs a takeoff step before it");
  if (measured_) refuse(node, "only one step can be the measured one");
  measured_ = true;
}

void FlightRehearsal::finish(const base::ConfigNode& steps) const {
  if (airborne_) refuse(steps, "the flight ends in the air: add a land step");
  if (!measured_) {
    refuse(steps, "no hold is measured: give one hold or trajectory 'measure: true'");
  }
}

void FlightRehearsal::refuse(const base::ConfigNode& node, const std::string& sentence) const {
  node.fail(who_.empty() ? sentence : who_ + ": " + sentence);
}

}  // namespace cas::hils
