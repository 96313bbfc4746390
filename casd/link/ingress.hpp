// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "base/os/lack_of_memory.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/link/switchboard.hpp"
#include "casd/routing/routing_rules.hpp"
#include "casd/signing/link_signing.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/sequence_tracker.hpp"

namespace cas::casd {

/// Finds packets in the bytes of one stream or of datagrams.
using Parser = mav::PacketParser;
Parser make_parser();

/// The receiving side of a link: bytes -> packets -> router -> the ports of their destinations, all
/// on the thread that read the bytes.
class Ingress {
 public:
  /// @param signing  empty: signatures are not looked at
  Ingress(LinkId link, Switchboard& switchboard, std::shared_ptr<LinkCounters> counters,
          AcceptRule accept = {}, std::shared_ptr<LinkSigning> signing = nullptr);

  /// Bytes of a stream. Packets are collected until deliver().
  void take(Parser& parser, std::span<const std::uint8_t> bytes, base::RunTime now,
            PeerId peer = {});
  /// Bytes that end with a packet, as a record of a telemetry log does.
  /// @param waited  how long it lay in the socket before `now`
  void take_datagram(Parser& parser, std::span<const std::uint8_t> bytes, base::RunTime now,
                     base::Duration waited = {});
  /// Finds the packets in such bytes that the link lets pass and calls on_packet for each.
  template <class OnPacket>
  void parse_datagram(Parser& parser, std::span<const std::uint8_t> bytes, OnPacket&& on_packet) {
    parse_stream(parser, bytes, on_packet);
    flush(parser, on_packet);
  }
  /// The same for bytes of a stream.
  template <class OnPacket>
  void parse_stream(Parser& parser, std::span<const std::uint8_t> bytes, OnPacket&& on_packet) {
    const Parser::Stats before = parser.stats();
    counters_->rx.bytes.add(bytes.size());
    parser.feed(
        bytes, [&](const mav::PacketView& packet) { admit(packet, on_packet); },
        [&](const mav::PacketView& packet) { admit_unknown(packet, on_packet); });
    count_parser(parser, before);
  }
  /// Gives up the half packet that the parser holds: finds the whole ones inside it.
  template <class OnPacket>
  void flush(Parser& parser, OnPacket&& on_packet) {
    if (!parser.inside_packet()) return;
    const Parser::Stats before = parser.stats();
    parser.flush([&](const mav::PacketView& packet) { admit(packet, on_packet); },
                 [&](const mav::PacketView& packet) { admit_unknown(packet, on_packet); });
    count_parser(parser, before);
  }
  /// One packet that is known to be whole.
  void take_packet(const mav::PacketView& packet, base::RunTime now, PeerId peer = {},
                   base::Duration waited = {});
  /// One packet of casd's own station for the vehicle at the end of these paths alone.
  void take_addressed(const mav::PacketView& packet, std::span<const Path> to, base::RunTime now);
  /// Hands the collected packets over: after each read.
  void deliver(base::RunTime now);
  /// Once a second.
  void tick(base::RunTime now);
  /// Lets go of the ports; nothing may be delivered afterwards.
  void let_go() { ports_.reset(); }
  LinkId link() const { return link_; }

 private:
  template <class OnPacket>
  void admit_unknown(const mav::PacketView& packet, OnPacket& on_packet) {
    if (switchboard_.router().passes_unknown(link_)) admit(packet, on_packet);
  }
  /// Only packets with a right signature count as received. Lack of memory costs this packet alone.
  template <class OnPacket>
  void admit(const mav::PacketView& packet, OnPacket& on_packet) {
    const auto pass = [&] {
      if (!signing_) return on_packet(packet);
      if (const auto admitted = signing_->admit(packet)) on_packet(*admitted);
    };
    if (!base::outlive_lack_of_memory(counters_->name, pass)) counters_->rx.no_memory.add();
  }
  bool admit_packet(const mav::PacketView& packet, base::RunTime now);
  void account(const Route& route, const mav::PacketView& packet, base::RunTime now);
  void count_refusals(const Route& route);
  void log_loop() const;
  void tell_held(const Route& route);
  void add_for_sniffers(const Route& route, const mav::PacketView& packet, base::RunTime now);
  void count_parser(const Parser& parser, const Parser::Stats& before);

  LinkId link_;
  Switchboard& switchboard_;
  std::shared_ptr<LinkCounters> counters_;
  AcceptRule accept_;
  bool accepts_all_;
  bool told_held_ = false;
  std::shared_ptr<LinkSigning> signing_;
  mav::SequenceTracker sequence_;
  DeliveryBatch batch_;
  std::shared_ptr<const PortTable> ports_;
  std::uint64_t ports_generation_ = 0;
};

}  // namespace cas::casd
