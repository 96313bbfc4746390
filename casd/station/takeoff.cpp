// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/takeoff.hpp"

#include <optional>

namespace cas::casd {

using mavlink::common::MavCmd;

void Takeoff::begin(KnownVehicle& vehicle, double altitude_m, Done done) {
  const std::uint64_t disarms = table_.hands(vehicle.state.source().system).disarms;
  if (vehicle.state.autopilot() == Autopilot::kArduPilot) {
    in_guided(vehicle, altitude_m, disarms, std::move(done));
  } else {
    to_amsl(vehicle, altitude_m, disarms, std::move(done));
  }
}

/// PX4: the altitude is above mean sea level. While home is unknown, the parameter
/// MIS_TAKEOFF_ALT carries the height and NaN says "here".
void Takeoff::to_amsl(KnownVehicle& vehicle, double altitude_m, std::uint64_t disarms, Done done) {
  VehicleCommand command = here_command(vehicle.state, MavCmd::kNavTakeoff);
  if (const std::optional<HomeAmsl> home = vehicle.state.home()) {
    command.params[6] = static_cast<float>(home->alt_m + altitude_m);
    give(vehicle, command, disarms, std::move(done));
    return;
  }
  // Else its answer is taken for this one's, and this for the owner's.
  if (vehicle.takeoff_height.is_putting_back()) {
    vehicle.takeoff_height.after_putting_back(
        [this, &vehicle, altitude_m, disarms, done = std::move(done)](const Outcome& put) {
          if (put.kind == OutcomeKind::kTimeout) return done(put);
          to_amsl(vehicle, altitude_m, disarms, done);
        });
    return;
  }
  vehicle.takeoff_height.write(
      altitude_m, clock_,
      [this, &vehicle, command, disarms, done = std::move(done)](const Outcome& set) {
        if (!set.ok()) return done(set);
        give(vehicle, command, disarms, [this, &vehicle, done](const Outcome& taken) {
          if (!taken.ok()) vehicle.takeoff_height.put_back(clock_());
          done(taken);
        });
      });
}

/// ArduPilot: takes off in GUIDED mode only, to a height above home.
void Takeoff::in_guided(KnownVehicle& vehicle, double altitude_m, std::uint64_t disarms,
                        Done done) {
  VehicleCommand command{.id = MavCmd::kNavTakeoff};
  command.params[6] = static_cast<float>(altitude_m);
  set_mode_(vehicle, "GUIDED",
            [this, &vehicle, command, disarms, done = std::move(done)](const Outcome& guided) {
              if (!guided.ok()) return done(guided);
              give(vehicle, command, disarms, done);
            });
}

/// The last of the requests. @param disarms  how many there were before the first one
void Takeoff::give(KnownVehicle& vehicle, const VehicleCommand& command, std::uint64_t disarms,
                   Done done) {
  if (table_.hands(vehicle.state.source().system).disarms != disarms) {
    done(failure(OutcomeKind::kRefused, describe(command.id) + " was overtaken by a disarm"));
    return;
  }
  vehicle.commands.start(command, clock_(), std::move(done));
}

}  // namespace cas::casd
