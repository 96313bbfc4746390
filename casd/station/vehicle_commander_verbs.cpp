// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/earth/geodesy.hpp"
#include "casd/station/vehicle_commander.hpp"

namespace cas::casd {
namespace {

using mavlink::common::MavCmd;
using mavlink::common::MavModeFlag;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// MAV_CMD_DO_REPOSITION param2: go there now, in the mode that takes such targets.
constexpr float kChangeMode = 1;
/// Farther from home than any vehicle here flies: a number beyond it is a slip.
constexpr double kFarthest_m = 100'000;

/// DO_SET_MODE with the armed and HIL flags as they are.
VehicleCommand mode_command(const VehicleState& state, std::uint32_t mode) {
  constexpr MavModeFlag kKept = MavModeFlag::kSafetyArmed | MavModeFlag::kHilEnabled;
  MavModeFlag flags = MavModeFlag::kCustomModeEnabled;
  if (state.autopilot() == Autopilot::kPx4) flags |= state.heartbeat().message.base_mode & kKept;
  const ModeParams params = mode_params(state.autopilot(), mode);
  VehicleCommand command{.id = MavCmd::kDoSetMode};
  command.params = {static_cast<float>(flags), params.main, params.sub, 0, 0, 0, 0};
  return command;
}

/// A command whose unused parameters mean "as it is": NaN for PX4, zero for ArduPilot.
VehicleCommand here_command(const VehicleState& state, MavCmd id) {
  VehicleCommand command{.id = id};
  if (state.autopilot() != Autopilot::kArduPilot) {
    command.params = {0, 0, 0, kNan, kNan, kNan, kNan};
  }
  return command;
}

std::string vehicle_text(const VehicleState& state) {
  return "vehicle " + std::to_string(state.source().system);
}

}  // namespace

void VehicleCommander::takeoff(std::uint8_t system, double altitude_m, base::RunTime now,
                               Done done) {
  now_ = now;
  Vehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  if (!(altitude_m > 0 && altitude_m <= kFarthest_m)) {
    done(failure(OutcomeKind::kInvalid, "a takeoff altitude is above 0 m and at most 100 km"));
    return;
  }
  if (vehicle->state.autopilot() == Autopilot::kArduPilot) {
    takeoff_guided(*vehicle, altitude_m, now, std::move(done));
  } else {
    takeoff_amsl(*vehicle, altitude_m, now, std::move(done));
  }
}

/// PX4: the altitude is above mean sea level. While home is unknown, the parameter
/// MIS_TAKEOFF_ALT carries the height and NaN says "here".
void VehicleCommander::takeoff_amsl(Vehicle& vehicle, double altitude_m, base::RunTime now,
                                    Done done) {
  const std::uint8_t system = vehicle.state.source().system;
  VehicleCommand command = here_command(vehicle.state, MavCmd::kNavTakeoff);
  if (const std::optional<HomeAmsl> home = vehicle.state.home()) {
    command.params[6] = static_cast<float>(home->alt_m + altitude_m);
    start(system, command, now, std::move(done));
    return;
  }
  set_param(system, "MIS_TAKEOFF_ALT", altitude_m, now,
            [this, system, command, done = std::move(done)](const Outcome& set) {
              if (!set.ok()) return done(set);
              start(system, command, now_, done);
            });
}

/// ArduPilot: takes off in GUIDED mode only, to a height above home.
void VehicleCommander::takeoff_guided(Vehicle& vehicle, double altitude_m, base::RunTime now,
                                      Done done) {
  const std::uint8_t system = vehicle.state.source().system;
  VehicleCommand command{.id = MavCmd::kNavTakeoff};
  command.params[6] = static_cast<float>(altitude_m);
  set_mode(system, "GUIDED", now,
           [this, system, command, done = std::move(done)](const Outcome& guided) {
             if (!guided.ok()) return done(guided);
             start(system, command, now_, done);
           });
}

void VehicleCommander::land(std::uint8_t system, base::RunTime now, Done done) {
  if (const Vehicle* vehicle = known(system, done)) {
    start(system, here_command(vehicle->state, MavCmd::kNavLand), now, std::move(done));
  }
}

void VehicleCommander::return_home(std::uint8_t system, base::RunTime now, Done done) {
  start(system, VehicleCommand{.id = MavCmd::kNavReturnToLaunch}, now, std::move(done));
}

void VehicleCommander::hold(std::uint8_t system, base::RunTime now, Done done) {
  if (const Vehicle* vehicle = known(system, done)) {
    // ArduPilot's LOITER follows the sticks; BRAKE stops and stays without a pilot.
    const bool ardupilot = vehicle->state.autopilot() == Autopilot::kArduPilot;
    set_mode(system, ardupilot ? "BRAKE" : "HOLD", now, std::move(done));
  }
}

void VehicleCommander::set_mode(std::uint8_t system, std::string_view word, base::RunTime now,
                                Done done) {
  const Vehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  const VehicleState& state = vehicle->state;
  const std::optional<std::uint32_t> mode = custom_mode(state.autopilot(), word);
  if (!mode) {
    const std::string words = mode_words(state.autopilot());
    done(failure(OutcomeKind::kInvalid, "'" + std::string(word) + "' is no mode of " +
                                        std::string(name(state.autopilot())) +
                                        (words.empty() ? std::string() : "; it has " + words)));
    return;
  }
  start(system, mode_command(state, *mode), now, std::move(done));
}

void VehicleCommander::go_to(std::uint8_t system, const Target& target, base::RunTime now,
                             Done done) {
  const Vehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  const std::optional<HomeAmsl> home = vehicle->state.home();
  if (!home) {
    done(failure(OutcomeKind::kRefused, vehicle_text(vehicle->state) +
                                        " has not told its home position yet; wait for its "
                                        "position estimate"));
    return;
  }
  const double north_m = target.north_m - home->x_m;
  const double east_m = target.east_m - home->y_m;
  const double down_m = target.down_m - home->z_m;
  if (!(std::hypot(north_m, east_m, down_m) <= kFarthest_m)) {
    done(failure(OutcomeKind::kInvalid, "a place to go to lies within 100 km of home"));
    return;
  }
  const base::LocalProjection projection({home->lat_deg, home->lon_deg, home->alt_m});
  const base::Geodetic place = projection.to_geodetic({north_m, east_m, down_m});
  VehicleCommand command{.id = MavCmd::kDoReposition};
  const double yaw_rad = target.yaw_deg.value_or(0) * std::numbers::pi / 180;
  command.params = {-1, kChangeMode, 0, target.yaw_deg ? static_cast<float>(yaw_rad) : kNan,
                    0,  0,           0};
  command.place = VehicleCommand::Place{static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7)),
                                        static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7)),
                                        static_cast<float>(home->alt_m - down_m)};
  start(system, command, now, std::move(done));
}

void VehicleCommander::message_interval(std::uint8_t system, std::uint32_t message_id,
                                        double period_us, base::RunTime now, Done done) {
  VehicleCommand command{.id = MavCmd::kSetMessageInterval};
  command.params[0] = static_cast<float>(message_id);
  command.params[1] = static_cast<float>(period_us);
  start(system, command, now, std::move(done));
}

void VehicleCommander::reboot(std::uint8_t system, base::RunTime now, Done done) {
  VehicleCommand command{.id = MavCmd::kPreflightRebootShutdown};
  command.params[0] = 1;
  start(system, command, now, std::move(done));
}

}  // namespace cas::casd
