// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Hands one whole packet to the router as if it came from casd's own station. Packets without a
/// target go to every link, packets with one only to links where the target was heard.
/// Only to be called on casd's main thread; never blocks.
using SendPacket = std::function<void(std::span<const std::uint8_t>)>;

/// What sits behind casd's own address (254/190 by default): hears every packet that is addressed
/// to it or to everybody, apart from HIL_* sensor and actuator streams. All calls come on casd's
/// main io thread; packets cross over from the link threads through a bounded queue.
class Station {
 public:
  virtual ~Station() = default;
  /// `packet` lives during the call only.
  virtual void on_packet(LinkId from, const mav::PacketView& packet, base::RunTime now) = 0;
  /// Every 50 ms: retries, timeouts, heartbeats.
  virtual void tick(base::RunTime now) = 0;
};

}  // namespace cas::casd
