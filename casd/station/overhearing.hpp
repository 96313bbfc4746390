// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"
#include "casd/station/vehicle_table.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Notes in the vehicles' Hands commands of other stations: through casd, or, seen by a vehicle's
/// answer, at another link. A disarm ends commands that may start motors.
///
/// @param self  casd's own station
void overhear(VehicleTable& table, mav::Source self, const Origin& from,
              const mav::PacketView& packet, base::RunTime now);

}  // namespace cas::casd
