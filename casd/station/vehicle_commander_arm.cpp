// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "casd/station/vehicle_commander.hpp"
#include "casd/station/vehicle_health.hpp"

namespace cas::casd {
namespace {

using mavlink::common::MavCmd;
using mavlink::common::MavModeFlag;

/// MAV_CMD_COMPONENT_ARM_DISARM param2: act against the vehicle's own checks.
constexpr float kForce = 21196;
constexpr base::Duration kFreshHeartbeat = std::chrono::seconds(3);

VehicleCommand arm_command(bool arm, bool force) {
  VehicleCommand command{.id = MavCmd::kComponentArmDisarm};
  command.params[0] = arm ? 1.0F : 0.0F;
  command.params[1] = force ? kForce : 0.0F;
  return command;
}

/// Whether a command may start motors.
bool spins(const VehicleCommand& command) {
  switch (command.id) {
    case MavCmd::kComponentArmDisarm:
      return command.params[0] != 0;
    case MavCmd::kDoSetMode: {
      // What is no set of flags may be read as anything.
      if (!(command.params[0] >= 0 && command.params[0] <= 255)) return true;
      const auto flags = static_cast<MavModeFlag>(static_cast<std::uint8_t>(command.params[0]));
      return has(flags, MavModeFlag::kSafetyArmed);
    }
    case MavCmd::kDoMotorTest:
    case MavCmd::kActuatorTest:
      return true;
    default:
      return false;
  }
}

/// Whether PX4 stands in a mode that flies by somebody's sticks.
bool waits_for_sticks(const VehicleState& state) {
  if (state.autopilot() != Autopilot::kPx4) return false;
  const std::string mode = state.mode();
  return mode == "MANUAL" || mode == "ALTCTL" || mode == "POSCTL" || mode == "STABILIZED" ||
         mode == "ACRO";
}

std::string vehicle_text(const VehicleState& state) {
  return "vehicle " + std::to_string(state.source().system);
}

}  // namespace

/// Real propellers may spin: answers `done` and returns true unless the vehicle says that it flies
/// a simulation, or request and configuration both consent to one that does not.
bool VehicleCommander::interlocked(const Vehicle& vehicle, bool not_hil, base::RunTime now,
                                   const Done& done) const {
  const VehicleState& state = vehicle.state;
  if (not_hil && options_.allow_not_hil) return false;
  std::string why;
  if (state.heartbeat_age(now) > kFreshHeartbeat) {
    why = " has sent no HEARTBEAT for " +
          std::to_string(static_cast<int>(base::to_seconds(state.heartbeat_age(now)))) +
          " s, so casd cannot tell whether it is in HIL mode";
  } else if (!state.hil()) {
    why = " does not say that it is in HIL mode: real propellers may spin";
  } else {
    return false;
  }
  constexpr const char* kRemedy =
      "; put it in HIL mode (PX4: SYS_HITL 1 and a restart), or, for a firmware that runs in "
      "software and never says so, allow it: commanding.allow_not_hil: true and --not-hil";
  why += not_hil ? "; --not-hil also needs commanding.allow_not_hil: true in casd's configuration"
                 : kRemedy;
  done(failure(OutcomeKind::kInterlock, vehicle_text(state) + why));
  return true;
}

void VehicleCommander::arm(std::uint8_t system, ArmOptions options, base::RunTime now, Done done) {
  now_ = now;
  const VehicleCommand command = arm_command(true, options.force);
  const Vehicle* vehicle = known(system, done);
  if (vehicle == nullptr || interlocked(*vehicle, options.not_hil, now, done)) return;
  start(system, command, now,
        [this, system, command, done = explained(*vehicle, std::move(done))](const Outcome& armed) {
          const VehicleState* state = find(system);
          if (armed.kind != OutcomeKind::kRefused || !waits_for_sticks(*state)) return done(armed);
          // Nobody holds sticks that this mode wants: in HOLD the vehicle flies by itself.
          set_mode(system, "HOLD", now_, [this, system, command, done](const Outcome& held) {
            if (!held.ok()) return done(held);
            start(system, command, now_, done);
          });
        });
}

/// Adds to a refusal what the vehicle is known to lack. What it said before it was asked may be
/// over.
Done VehicleCommander::explained(const Vehicle& vehicle, Done done) {
  const std::uint8_t system = vehicle.state.source().system;
  const std::uint64_t texts_before = vehicle.state.status_text_count();
  return [this, system, texts_before, done = std::move(done)](const Outcome& outcome) {
    const VehicleState* state = find(system);
    if (outcome.kind != OutcomeKind::kRefused || state == nullptr) return done(outcome);
    Outcome told = outcome;
    for (const std::string& complaint : complaints(*state, now_, texts_before)) {
      if (told.message.find(complaint) == std::string::npos) told.message += "; " + complaint;
    }
    done(told);
  };
}

void VehicleCommander::disarm(std::uint8_t system, bool force, base::RunTime now, Done done) {
  start(system, arm_command(false, force), now, std::move(done));
}

void VehicleCommander::command(std::uint8_t system, const VehicleCommand& command, bool not_hil,
                               base::RunTime now, Done done) {
  now_ = now;
  Vehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  if (spins(command) && interlocked(*vehicle, not_hil, now, done)) return;
  vehicle->commands.start(command, now, std::move(done));
}

}  // namespace cas::casd
