// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "mavlink_gen/runtime/message_table.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// What a packet is to a link that cannot carry everything.
enum class TrafficClass : std::uint8_t {
  kCommand,    ///< commands, parameters, missions, file transfer, heartbeats, time: never lost
  kHil,        ///< the HIL loop's sensor and actuator packets: worthless when late
  kGps,        ///< slow sensors of the HIL loop: worth more than one packet of the fast ones
  kTelemetry,  ///< everything else: yields
};
inline constexpr int kTrafficClasses = 4;

/// The class of a message by its id; ids that no public dialect knows are telemetry.
TrafficClass classify(std::uint32_t message_id);

std::string_view to_string(TrafficClass traffic);

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

/// The stamp (microseconds) that, with the message id, is a HIL packet's identity in every ledger:
/// time_usec of HIL_SENSOR, HIL_GPS and the two controls; nothing for other packets.
std::optional<std::uint64_t> hil_time_usec(const mav::PacketView& packet);

/// Reads the addresses from the payload as it came (a field cut off with trailing zeros is 0).
PacketInfo inspect(const mav::PacketView& packet, const mav::MessageTable& table);

}  // namespace cas::casd
