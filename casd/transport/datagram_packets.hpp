// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/link/held_packets.hpp"
#include "casd/link/ingress.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

/// Finds the packets in the datagrams of a socket. A bridge from a serial line may cut its bytes
/// anywhere: the half packet at the end of a datagram waits for the next one of the same sender.
///
/// Whole packets leave with their datagram, also behind a half one whose rest did not come: when
/// the datagram begins or ends with them. Whole packets between two halves leave after
/// kPacketPause. A half packet is forgotten after kKept. Senders that are no peers have few places
/// of their own, so that they displace no half packet of a peer.
class DatagramPackets {
 public:
  static constexpr base::Duration kKept = std::chrono::seconds(1);
  static constexpr std::size_t kMaxStrangers = 16;

  /// Calls on_packet(const mav::PacketView&) for each packet that this datagram completes.
  /// @param is_peer  tells whether its sender is known by now
  template <class IsPeer, class OnPacket>
  void take(Ingress& ingress, const PeerAddress& sender, IsPeer&& is_peer,
            std::span<const std::uint8_t> bytes, base::RunTime now, OnPacket&& on_packet) {
    if (halves_.empty()) {
      ingress.parse_stream(whole_, bytes, on_packet);
      if (whole_.inside_packet()) [[unlikely]]
        keep(ingress, sender, is_peer(), now, on_packet);
      return;
    }
    Half* const half = find(sender);
    Parser& parser = half == nullptr ? whole_ : half->parser;
    if (half != nullptr && parser.inside_packet() &&
        (now - half->last > kKept || begins_anew(parser, bytes))) {
      ingress.flush(parser, on_packet);
    }
    ingress.parse_stream(parser, bytes, on_packet);
    if (parser.inside_packet()) keep(ingress, sender, is_peer(), now, on_packet);
  }

  /// When release() has something to do.
  base::RunTime due() const { return due_; }
  /// Calls on_packet(const PeerAddress& sender, const mav::PacketView&) for whole packets that
  /// waited between two halves, and forgets old halves.
  template <class OnPacket>
  void release(Ingress& ingress, base::RunTime now, OnPacket&& on_packet) {
    for (const auto& half : halves_) {
      const base::Duration age = now - half->last;
      if (age < kKept && (age < kPacketPause || !half->waits)) continue;
      half->waits = false;
      if (age < kKept && !holds_packets(half->parser)) continue;
      ingress.flush(half->parser,
                    [&](const mav::PacketView& packet) { on_packet(half->sender, packet); });
    }
    forget_old(now);
  }
  /// The socket is another one.
  void reset();

 private:
  struct Half {
    PeerAddress sender;
    bool is_peer = false;
    bool waits = false;  ///< not looked into since the last datagram
    base::RunTime last;  ///< when the last datagram came that ended inside a packet
    Parser parser = make_parser();
  };

  /// A datagram ended inside a packet.
  template <class OnPacket>
  void keep(Ingress& ingress, const PeerAddress& sender, bool is_peer, base::RunTime now,
            OnPacket& on_packet) {
    Half* half = find(sender);
    Parser& parser = half == nullptr ? whole_ : half->parser;
    if (ends_with_packet(parser)) return ingress.flush(parser, on_packet);
    if (half == nullptr) half = &add(sender, is_peer);
    half->is_peer = is_peer;
    half->waits = true;
    half->last = now;
    due_ = std::min(due_, now + kPacketPause);
  }

  Half* find(const PeerAddress& sender);
  /// Moves the half packet of whole_ to a place of this sender.
  Half& add(const PeerAddress& sender, bool is_peer);
  void forget_old(base::RunTime now);

  Parser whole_ = make_parser();  ///< empty between two datagrams
  std::vector<std::unique_ptr<Half>> halves_;
  base::RunTime due_ = base::RunTime::max();
};

}  // namespace cas::casd
