// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <array>
#include <bit>
#include <cstdint>
#include <optional>

#include "base/time/clock.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/routing/route_table.hpp"

namespace cas::casd {

/// The peers of a UDP server: up to 64 addresses with the ids heard from each. Silent peers are
/// forgotten. Addressed packets go only to peers that have announced the target.
///
/// The link's thread changes it; senders read it. `add`, `expire` and `clear` exclude `for_packet`
/// and `address` by a lock of the caller; the rest needs none.
class PeerTable {
 public:
  static constexpr int kMaxPeers = kSlots;

  PeerTable(int max_peers, base::Duration expiry);

  /// The slot of an address. @return nothing when it is unknown
  std::optional<std::uint8_t> find(const sockaddr_storage& address) const;
  /// Takes a new address in. When all slots are taken by peers that still speak, the newest peer of
  /// the machine that has most of them gives way to a machine that has two fewer. @return nothing
  /// when there is none
  /// @param socket  of the server's, over which it was heard
  std::optional<std::uint8_t> add(const sockaddr_storage& address, socklen_t size,
                                  base::RunTime now, std::uint8_t socket = 0);
  /// Slot and serial number of a peer that is present.
  PeerId id(std::uint8_t peer) const { return {peer, peers_[peer].serial}; }
  /// A packet came from the peer. @param rarely  a message that comes_rarely()
  void heard(std::uint8_t peer, mav::Source source, base::RunTime now, bool rarely = false);
  /// Forgets silent peers. @return how many
  int expire(base::RunTime now);
  void clear();

  /// Peers that are to get this packet: all or those that announced the target, never its sender.
  /// A packet for one peer alone (`to_serial`) goes to no other.
  /// @param own  the link that the peers are on
  SlotMask for_packet(const PacketInfo& info, LinkId own) const;

  SlotMask present() const { return present_; }
  int count() const { return std::popcount(present_); }
  const sockaddr* address(std::uint8_t peer) const {
    return reinterpret_cast<const sockaddr*>(&peers_[peer].address);
  }
  socklen_t address_size(std::uint8_t peer) const { return peers_[peer].size; }
  std::uint8_t socket(std::uint8_t peer) const { return peers_[peer].socket; }

 private:
  struct Peer {
    sockaddr_storage address{};
    socklen_t size = 0;
    base::RunTime last;
    std::uint32_t serial = 0;
    std::uint8_t socket = 0;
    bool rarely = false;
  };
  void remove(std::uint8_t peer);
  int count_of_host(const sockaddr_storage& address) const;
  /// Frees a slot for a peer of this address. @return false when its machine has its share
  bool make_room(const sockaddr_storage& address);

  int max_peers_;
  std::uint32_t serials_ = 0;  ///< given so far
  base::Duration expiry_;
  SlotMask present_ = 0;
  std::array<Peer, kMaxPeers> peers_;
  RouteTable routes_;
  mutable std::uint8_t newest_ = 0;  ///< found last: almost always the next one's
};

}  // namespace cas::casd
