// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// The messages that ground stations send (`accept: {traffic: ground_station}`), in rising order:
/// commands, parameters, missions, sticks and setpoints, files, logs, corrections for the receiver.
/// Not what vehicles, their sensors and simulators say: HIL_*, positions measured elsewhere,
/// telemetry.
std::span<const std::uint32_t> ground_station_messages();

/// Whether a ground station may have sent it: one of ground_station_messages(), and no vehicle's
/// HEARTBEAT.
bool is_ground_station_traffic(const mav::PacketView& packet);

/// Whether a vehicle, or a part of it, may say this message: not if it is one that ground stations
/// send and vehicles only take.
bool may_be_of_vehicle(std::uint32_t message_id);
/// Whether a vehicle may have sent it: may_be_of_vehicle(), and no ground station's HEARTBEAT.
bool is_vehicle_traffic(const mav::PacketView& packet);

}  // namespace cas::casd
