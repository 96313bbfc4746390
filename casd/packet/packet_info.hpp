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

/// Priority class of a packet on a link that cannot carry everything.
enum class TrafficClass : std::uint8_t {
  kCommand,    ///< commands, parameters, missions, file transfer, heartbeats, time: never lost
  kHil,        ///< the HIL loop's sensor and actuator packets: worthless when late
  kGps,        ///< slow sensors of the HIL loop: worth more than one packet of the fast ones
  kSetpoint,   ///< sticks and targets that are streamed: only the newest is worth anything
  kTelemetry,  ///< everything else: yields
};
inline constexpr int kTrafficClasses = 5;

/// Message ids below this are looked up in tables: nearly all that public dialects send.
inline constexpr std::uint32_t kTabledIds = 512;

/// The class of a message by its id; ids that no public dialect knows are telemetry.
TrafficClass classify(std::uint32_t message_id);

std::string_view to_string(TrafficClass traffic);

inline constexpr std::uint8_t kNoPeer = 255;

/// One peer of a server link: its slot, which a later peer may get, and its serial number, which
/// none ever gets again on that link. 0: the link has no peers.
struct PeerId {
  std::uint8_t slot = kNoPeer;
  std::uint32_t serial = 0;
};

/// A way to one sender: a link, and on a server link the serial number of its peer.
struct Path {
  LinkId link = kNoLink;
  std::uint32_t peer = 0;  ///< 0: the link has no peers, or any of them

  friend bool operator==(const Path&, const Path&) = default;
};

/// Where a packet came from. The links of one group are redundant ways to the same senders.
struct Origin {
  Path path;
  std::int16_t group = -1;  ///< of the link; -1: none
};

/// Properties of a packet for the router and the queues, without its bytes.
struct PacketInfo {
  std::uint32_t message_id = 0;
  mav::Source source;
  mav::Source target;  ///< system 0: broadcast; component 0: every component of the system
  TrafficClass traffic = TrafficClass::kTelemetry;
  LinkId from = kNoLink;
  std::int16_t from_group = -1;      ///< group of the link; -1: none
  std::uint8_t from_peer = kNoPeer;  ///< slot of the peer of a server link that sent it
  std::uint32_t from_serial = 0;     ///< serial number of that peer
  std::uint32_t to_serial = 0;       ///< the one peer of a server link that may get it; 0: any
  bool to_all_peers = false;         ///< of a server link, whatever the target: it is a sniffer
  base::RunTime received;            ///< when the link read it
  base::Duration waited{};           ///< before that, in the socket; 0 while casd keeps up
  std::uint64_t hil_time_usec = 0;   ///< stamp of HIL_SENSOR, HIL_GPS and the controls; else 0
};

/// The stamp (microseconds) that, with the message id, is a HIL packet's identity in every ledger:
/// time_usec of HIL_SENSOR, HIL_GPS and the two controls; nullopt for other packets.
std::optional<std::uint64_t> hil_time_usec(const mav::PacketView& packet);

/// Reads the addresses from the payload as it came (a field cut off with trailing zeros is 0).
PacketInfo inspect(const mav::PacketView& packet, const mav::MessageTable& table);

}  // namespace cas::casd
