// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/vehicle_command.hpp"

#include <cmath>
#include <limits>

#include "base/angles.hpp"
#include "base/earth/deg_e7.hpp"
#include "base/earth/geodesy.hpp"

namespace cas::casd {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// MAV_CMD_DO_REPOSITION param2: go there now, in the mode that takes such targets.
constexpr float kChangeMode = 1;

}  // namespace

VehicleCommand reposition_command(const HomeAmsl& home, double north_m, double east_m,
                                  double down_m, std::optional<double> yaw_deg) {
  const base::LocalProjection projection({home.lat_deg, home.lon_deg, home.alt_m});
  const base::Geodetic place = projection.to_geodetic({north_m, east_m, down_m});
  VehicleCommand command{.id = mavlink::common::MavCmd::kDoReposition};
  const double yaw_rad = base::radians(yaw_deg.value_or(0));
  command.params = {-1, kChangeMode, 0, yaw_deg ? static_cast<float>(yaw_rad) : kNan, 0, 0, 0};
  command.place = VehicleCommand::Place{base::deg_e7(place.lat_deg), base::deg_e7(place.lon_deg),
                                        static_cast<float>(home.alt_m - down_m)};
  return command;
}

VehicleCommand circling(VehicleCommand reposition, Autopilot autopilot, double radius_m) {
  const auto radius = static_cast<float>(radius_m);
  if (autopilot != Autopilot::kPx4) {
    reposition.params[2] = radius;
    return reposition;
  }
  reposition.id = mavlink::common::MavCmd::kDoOrbit;
  constexpr float kForever = 0;
  reposition.params = {radius, kNan, kNan, kForever, 0, 0, 0};
  return reposition;
}

}  // namespace cas::casd
