// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/takeoff.hpp"

#include <optional>
#include <utility>

namespace cas::casd {

using mavlink::common::MavCmd;

void Takeoff::begin(KnownVehicle& vehicle, double altitude_m, bool not_hil, Done done) {
  const Request request{.altitude_m = altitude_m,
                        .not_hil = not_hil,
                        .disarms = table_.hands(vehicle.state.source().system).disarms,
                        .done = std::move(done)};
  const bool plane =
      vehicle.state.mode_set() == ModeSet::kPlane && vehicle.state.vtol_word().empty();
  if (plane) {
    in_takeoff_mode(vehicle, request);
  } else if (vehicle.state.autopilot() == Autopilot::kArduPilot) {
    in_guided(vehicle, request);
  } else {
    to_amsl(vehicle, request);
  }
}

/// PX4: the altitude is above mean sea level. While home is unknown, the parameter
/// MIS_TAKEOFF_ALT carries the height and NaN says "here".
void Takeoff::to_amsl(KnownVehicle& vehicle, const Request& request) {
  VehicleCommand command = here_command(vehicle.state, MavCmd::kNavTakeoff);
  if (const std::optional<HomeAmsl> home = vehicle.state.home()) {
    command.params[6] = static_cast<float>(home->alt_m + request.altitude_m);
    give(vehicle, command, request);
    return;
  }
  with_height(vehicle, request, [this, &vehicle, command](const Request& putting_back) {
    give(vehicle, command, putting_back);
  });
}

/// ArduPlane: climbs to TKOFF_ALT in the mode TAKEOFF.
void Takeoff::in_takeoff_mode(KnownVehicle& vehicle, const Request& request) {
  with_height(vehicle, request, [this, &vehicle](const Request& putting_back) {
    if (!overtaken(vehicle, putting_back)) {
      set_mode_(vehicle, "TAKEOFF", putting_back.not_hil, putting_back.done);
    }
  });
}

/// Writes the height into the vehicle's parameter, then takes off; a takeoff that is refused
/// restores the parameter.
void Takeoff::with_height(KnownVehicle& vehicle, const Request& request,
                          std::function<void(const Request&)> take_off) {
  // The vehicle's answers to two writes of one parameter cannot be told apart: wait for the first.
  if (vehicle.takeoff_height.is_putting_back()) {
    vehicle.takeoff_height.after_putting_back(
        [this, &vehicle, request, take_off = std::move(take_off)](const Outcome& put) {
          if (put.kind == OutcomeKind::kTimeout) return request.done(put);
          with_height(vehicle, request, take_off);
        });
    return;
  }
  vehicle.takeoff_height.write(
      request.altitude_m, clock_,
      [this, &vehicle, request, take_off = std::move(take_off)](const Outcome& set) {
        if (!set.ok()) return request.done(set);
        Request putting_back = request;
        putting_back.done = [this, &vehicle, done = request.done](const Outcome& taken) {
          if (!taken.ok()) vehicle.takeoff_height.put_back(clock_());
          done(taken);
        };
        take_off(putting_back);
      });
}

/// ArduPilot's copters and quadplanes: take off in GUIDED mode only, to a height above home.
void Takeoff::in_guided(KnownVehicle& vehicle, const Request& request) {
  VehicleCommand command{.id = MavCmd::kNavTakeoff};
  command.params[6] = static_cast<float>(request.altitude_m);
  set_mode_(vehicle, "GUIDED", request.not_hil,
            [this, &vehicle, command, request](const Outcome& guided) {
              if (!guided.ok()) return request.done(guided);
              give(vehicle, command, request);
            });
}

/// Whether a disarm came meanwhile, which ends the request.
bool Takeoff::overtaken(const KnownVehicle& vehicle, const Request& request) {
  if (table_.hands(vehicle.state.source().system).disarms == request.disarms) return false;
  request.done(
      failure(OutcomeKind::kRefused, describe(MavCmd::kNavTakeoff) + " was overtaken by a disarm"));
  return true;
}

/// Sends the takeoff itself.
void Takeoff::give(KnownVehicle& vehicle, const VehicleCommand& command, const Request& request) {
  if (!overtaken(vehicle, request)) start_(vehicle, command, request.not_hil, request.done);
}

}  // namespace cas::casd
