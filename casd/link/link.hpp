// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "base/time/clock.hpp"
#include "casd/link/poll_set.hpp"
#include "casd/packet/packet_port.hpp"

namespace cas::casd {

/// Packets whose arrival the kernel has stamped, since the link began: how many, and how long they
/// waited to be read, all together.
struct Arrivals {
  std::uint64_t packets = 0;
  base::Duration waited{};
};

/// One communication path: opens itself, reads packets into the router, reopens itself after every
/// trouble. All calls but those of port() come on the thread of its loop and never block.
///
///   LinkLoop::add -> (watch -> poll -> serve)* -> destroyed
///
/// A serial link, for example, opens its device in serve(), names the descriptor in watch(), and
/// after an unplug tries to open again in a later serve().
class Link {
 public:
  virtual ~Link() = default;
  /// Names what it waits for.
  virtual void watch(PollSet& set, base::RunTime now) = 0;
  /// Reads, writes, opens: whatever is due.
  virtual void serve(const PollSet& set, base::RunTime now) = 0;
  /// Packets that came and were taken for such, on the thread of the loop.
  virtual std::uint64_t received() const = 0;
  /// The same of those with a stamp; also on the thread of the loop.
  virtual Arrivals arrivals() const { return {}; }
  /// Where other links hand over packets for this one; from any thread.
  virtual std::shared_ptr<PacketPort> port() = 0;
};

}  // namespace cas::casd
