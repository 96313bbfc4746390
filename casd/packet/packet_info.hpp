// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/packet/traffic_class.hpp"
#include "mavlink_gen/runtime/message_table.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

inline constexpr std::uint8_t kNoPeer = 255;

/// What the router and the queues need to know of a packet, without its bytes.
struct PacketInfo {
  std::uint32_t message_id = 0;
  mav::Source source;
  mav::Source target;  ///< system 0: everybody; component 0: every component of the system
  TrafficClass traffic = TrafficClass::kTelemetry;
  LinkId from = kNoLink;
  std::uint8_t from_peer = kNoPeer;  ///< which peer of a server link sent it
  base::RunTime received;            ///< when the link read it
  std::uint64_t hil_time_usec = 0;   ///< stamp of HIL_SENSOR, HIL_GPS and the controls; else 0
};

/// Reads the addresses from the payload as it came (a field cut off with trailing zeros is 0).
PacketInfo inspect(const mav::PacketView& packet, const mav::MessageTable& table);

}  // namespace cas::casd
