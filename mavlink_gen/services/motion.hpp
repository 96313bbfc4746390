// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "mavlink/common/enums.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/command.hpp"
#include "mavlink_gen/services/vehicle_modes.hpp"

namespace cas::mav::services {

/// The most that a packet or command may have a vehicle do, in rising order of danger.
enum class Motion : std::uint8_t {
  kNone,      ///< nothing: telemetry, questions, answers
  kStops,     ///< stays where it is, lands, returns
  kCuts,      ///< stops motors at once, ends the flight: a flying vehicle falls
  kMisleads,  ///< may change what the vehicle takes for its place or surroundings
  kMoves,     ///< may move an armed vehicle or change how it flies
  kSpins,     ///< may start motors
};

/// What decides how a vehicle reads a command. The default is the worst case: an armed vehicle of
/// an unknown kind.
struct Addressee {
  Autopilot autopilot = Autopilot::kOther;
  mavlink::common::MavType type{};
  bool armed = true;
};
Addressee addressee_of(const mavlink::common::Heartbeat& heartbeat);

/// What a command may do. Commands that the function does not know count as kMoves.
Motion motion_of(const VehicleCommand& command, const Addressee& to);
/// What setting a parameter may do: kSpins if it arms, permits to arm or drives an output.
Motion motion_of_parameter(std::string_view name);
/// Whether setting a PX4's parameter leads into HIL and drives no output before that: SYS_HITL, the
/// simulated outputs, an airframe of HIL (1000 to 1999).
bool leads_into_hil(std::string_view parameter, double value);
/// What a packet may do. Messages of private dialects count as kMisleads, public ones that the
/// function does not know as kNone.
Motion motion_of(const PacketView& packet, const Addressee& to);

}  // namespace cas::mav::services
