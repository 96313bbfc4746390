// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight_rehearsal.hpp"

#include <string>

namespace cas::hils {

void FlightRehearsal::play(const FlightStep& step, const base::ConfigNode& node) {
  const std::string word(to_string(step.kind));
  switch (step.kind) {
    case StepKind::kArm:
      if (armed_) node.fail("the vehicle is armed already");
      armed_ = true;
      return;
    case StepKind::kTakeoff:
      if (!armed_) node.fail("takeoff needs an arm step before it");
      if (airborne_) node.fail("the vehicle is in the air already");
      airborne_ = true;
      return;
    case StepKind::kGoto:
    case StepKind::kTrajectory:
    case StepKind::kLand:
      if (!airborne_) node.fail(word + " needs a takeoff step before it");
      airborne_ = step.kind != StepKind::kLand;
      return play_measure(step, node);
    case StepKind::kHold:
      return play_measure(step, node);
    case StepKind::kDisarm:
      if (airborne_) node.fail("disarm in the air would drop the vehicle: land first");
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
  if (!airborne_) node.fail("a measured hold needs a takeoff step before it");
  if (measured_) node.fail("only one step can be the measured one");
  measured_ = true;
}

void FlightRehearsal::finish(const base::ConfigNode& steps) const {
  if (airborne_) steps.fail("the flight ends in the air: add a land step");
  if (!measured_) {
    steps.fail("no hold is measured: give one hold or trajectory 'measure: true'");
  }
}

}  // namespace cas::hils
