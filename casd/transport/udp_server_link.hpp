// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "base/os/mutex.hpp"
#include "casd/transport/datagram_link.hpp"
#include "casd/transport/peer_table.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

/// The peers of a server, shared by the link's thread (which changes them) and the senders.
struct SharedPeers {
  SharedPeers(int max_peers, base::Duration expiry) : table(max_peers, expiry) {}
  base::Mutex mutex;
  PeerTable table CAS_GUARDED_BY(mutex);

  /// For the link's thread, which alone changes it, to look without the lock.
  PeerTable& own_table() CAS_THREAD_SAFETY(no_thread_safety_analysis) { return table; }
};

/// UDP on one port for many: who sends a packet here becomes a peer and gets packets until it falls
/// silent. Also serves as `udp` without a remote: then the newest sender is the one peer.
class UdpServerLink final : public DatagramLink {
 public:
  explicit UdpServerLink(LinkContext context);

 private:
  void open(base::RunTime now) override;
  void take_datagram(const DatagramReader& reader, std::size_t index, base::RunTime now) override;
  void take_held(const PeerAddress& sender, const mav::PacketView& packet,
                 base::RunTime now) override;
  /// @param peer  of the sender; nothing: it is none yet
  void take_packet(std::optional<std::uint8_t>& peer, const PeerAddress& sender,
                   const mav::PacketView& packet, base::RunTime now, base::Duration waited);
  std::optional<std::uint8_t> admit(const PeerAddress& sender, base::RunTime now);
  void on_second(base::RunTime now) override;

  bool newest_only_;  ///< one peer: whoever spoke last
  std::shared_ptr<SharedPeers> peers_;
  AddressLookup local_;
  bool looking_up_ = false;
};

}  // namespace cas::casd
