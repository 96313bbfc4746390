// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_pilot.hpp"

#include <chrono>
#include <cmath>
#include <utility>

#include "base/angles.hpp"

namespace cas::hils {

namespace {

constexpr base::Duration kLookPeriod = std::chrono::milliseconds(50);

base::SimTime to_sim_time(base::RunTime t) { return base::SimTime(t.time_since_epoch()); }

}  // namespace

VirtualPilot::VirtualPilot(casd::VehicleCommander& commander, const Scenario& scenario,
                           casd::GainMap gains, Truth truth)
    : commander_(commander),
      gains_(std::move(gains)),
      plan_(scenario),
      truth_(std::move(truth)),
      vehicles_(scenario.vehicles.size()) {
  for (const ScenarioVehicle& vehicle : scenario.vehicles) systems_.push_back(vehicle.system_id);
}

void VirtualPilot::run(base::RunTime now) {
  now_ = now;
  next_look_ = now + kLookPeriod;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    vehicles_[i] = plan_.plan(i).from_arming(look(i));
  }
  for (const FleetPlan::Command& command : plan_.update(to_sim_time(now), vehicles_)) {
    give(command, now);
  }
}

VehicleReport VirtualPilot::look(std::size_t vehicle) const {
  VehicleReport report;
  report.truth = truth_(vehicle);
  const casd::VehicleState* state = commander_.find(systems_[vehicle]);
  if (state == nullptr) return report;
  report.heard = true;
  report.armed = state->armed();
  report.in_air = state->landed_word() == "in_air";
  report.on_ground = state->landed_word() == "on_ground";
  if (const auto& position = state->local_position()) {
    const auto& message = position->message;
    report.has_position = true;
    report.p_N = {message.x, message.y, message.z};
    report.v_N = {message.vx, message.vy, message.vz};
  }
  if (const auto& attitude = state->attitude()) {
    report.roll_rad = attitude->message.roll;
    report.pitch_rad = attitude->message.pitch;
    report.yaw_rad = attitude->message.yaw;
  }
  return report;
}

void VirtualPilot::give(const FleetPlan::Command& command, base::RunTime now) {
  const FlightStep& step = command.step;
  const std::uint8_t system = systems_[command.vehicle];
  // The commander reports on its own ticks and packets.
  casd::Done done = [this, vehicle = command.vehicle](const casd::Outcome& outcome) {
    std::optional<Refusal> refusal;
    if (!outcome.ok()) refusal = Refusal{outcome.message};
    plan_.on_outcome(vehicle, to_sim_time(now_), refusal);
  };
  switch (step.kind) {
    case StepKind::kArm:
      return commander_.arm(system, {}, now, std::move(done));
    case StepKind::kTakeoff:
      return commander_.takeoff(system, step.altitude_m, now, std::move(done));
    case StepKind::kGoto:
      return commander_.go_to(system,
                              {.north_m = step.place_m.x(),
                               .east_m = step.place_m.y(),
                               .down_m = -step.place_m.z(),
                               .yaw_deg = step.yaw_rad * base::kDegPerRad},
                              now, std::move(done));
    case StepKind::kSetGain:
      return set_gain(system, step, now, std::move(done));
    case StepKind::kLand:
      return commander_.land(system, now, std::move(done));
    case StepKind::kRtl:
      return commander_.return_home(system, now, std::move(done));
    case StepKind::kDisarm:
      return commander_.disarm(system, false, now, std::move(done));
    case StepKind::kSetParam:
    case StepKind::kTrajectory:
    case StepKind::kEndTrajectory:
      return set_params(system, step, 0, now, std::move(done));
    case StepKind::kMission:  // no scenario of our controller has one
    case StepKind::kBreach:
    case StepKind::kReboot:
    case StepKind::kHold:
    case StepKind::kWaitUntil:
    case StepKind::kStandBy:
      return done({});
  }
}

/// One after the other; the first refusal ends it.
void VirtualPilot::set_params(std::uint8_t system, const FlightStep& step, std::size_t index,
                              base::RunTime now, casd::Done done) {
  const auto& [name, value] = step.params[index];
  const bool last = index + 1 == step.params.size();
  commander_.set_param(
      system, name, value, now,
      [this, system, step, index, last, done = std::move(done)](const casd::Outcome& outcome) {
        if (last || !outcome.ok()) return done(outcome);
        set_params(system, step, index + 1, now_, done);
      });
}

void VirtualPilot::set_gain(std::uint8_t system, const FlightStep& step, base::RunTime now,
                            casd::Done done) {
  const casd::VehicleState* state = commander_.find(system);
  const casd::GainLoop* loop =
      state == nullptr ? nullptr : gains_.find(state->autopilot(), step.loop);
  if (loop == nullptr) {
    return done(casd::failure(casd::OutcomeKind::kInvalid, "there is no loop '" + step.loop + "'"));
  }
  commander_.set_gains(system, *loop, {.p = step.p, .i = step.i, .d = step.d}, now,
                       std::move(done));
}

}  // namespace cas::hils
