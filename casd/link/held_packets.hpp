// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <span>

#include "base/time/clock.hpp"
#include "casd/link/ingress.hpp"

namespace cas::casd {

/// A pause after which whole packets leave a half one that may hold them as its payload: the rest
/// of a packet comes sooner on any line that carries MAVLink.
inline constexpr base::Duration kPacketPause = std::chrono::milliseconds(100);

/// Whether whole packets wait in the half packet that a parser holds. Pure.
bool holds_packets(const Parser& parser);

/// Whether whole packets reach to the last byte that came: then the half one before them has no
/// rest, and a sender that cuts its packets anywhere did not send these bytes. Pure.
bool ends_with_packet(const Parser& parser);

/// Whether the bytes begin with a whole packet and complete no packet that the parser holds: their
/// sender has begun anew. Pure.
bool begins_anew(const Parser& parser, std::span<const std::uint8_t> bytes);

/// When the half packet of a stream lets go of whole ones that it holds.
class StreamPause {
 public:
  /// After each read.
  void after_read(const Parser& parser, base::RunTime now) {
    due_ = parser.inside_packet() ? now + kPacketPause : base::RunTime::max();
  }
  base::RunTime due() const { return due_; }

  /// At the end of a pause: calls on_packet for each whole packet that a half one held. A half
  /// packet without any stays, for the rest of it may come late.
  template <class OnPacket>
  void release(Ingress& ingress, Parser& parser, OnPacket&& on_packet) {
    due_ = base::RunTime::max();
    if (holds_packets(parser)) ingress.flush(parser, on_packet);
  }

 private:
  base::RunTime due_ = base::RunTime::max();
};

}  // namespace cas::casd
