// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "base/config/config.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/mavlink_message.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/message_table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "plugins/common/datagram_link.hpp"
#include "plugins/common/terrain_requests.hpp"

namespace cas::sim {

/// What a companion computer does for an autopilot whose sensors do not come by MAVLink: sends it
/// messages of plugins, and answers its TERRAIN_REQUEST. UDP packets to a link of casd, which
/// passes them to a link of the autopilot.
class Companion {
 public:
  /// @param remote  the key with HOST:PORT
  /// @param self  system and component of the packets
  /// @throws base::ConfigError through `remote`
  Companion(const base::ConfigNode& remote, mav::Source self);

  /// Never blocks: drops the packet, and counts it, if the socket is full.
  void send(const mav::MessageInfo& info, const MavlinkMessage& message);
  /// A step of a world with terrain: sends a HEARTBEAT each second, by which casd knows where to
  /// send requests, and the next grid that the autopilot has asked for. Never blocks.
  void serve_terrain(base::SimTime now, const TerrainSource::Elevation& elevation_m);
  /// Back to time zero.
  void reset();
  /// Figures of the DatagramLink; in a world with terrain also {"terrain_requests":9,"grids":504}.
  nlohmann::ordered_json figures() const;

 private:
  void read();
  template <class Message>
  void send(const Message& message);

  DatagramLink datagrams_;
  mav::Source self_;
  std::uint8_t sequence_ = 0;
  mav::PacketParser parser_;
  TerrainRequests terrain_;
  base::RateGate heartbeat_;
  bool serves_terrain_ = false;
  std::uint64_t requests_ = 0;
  std::uint64_t grids_ = 0;
};

}  // namespace cas::sim
