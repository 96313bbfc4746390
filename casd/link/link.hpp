// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <poll.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/packet/packet_port.hpp"

namespace cas::casd {

/// What a thread waits for: descriptors and the earliest moment at which something is due.
class PollSet {
 public:
  static constexpr base::RunTime kNever = base::RunTime::max();

  void clear() {
    entries_.clear();
    deadline_ = kNever;
  }
  /// @return where the answer will be found
  std::size_t add(int fd, short events) {
    entries_.push_back({fd, events, 0});
    return entries_.size() - 1;
  }
  void wake_by(base::RunTime when) { deadline_ = std::min(deadline_, when); }

  short revents(std::size_t index) const { return entries_[index].revents; }
  base::RunTime deadline() const { return deadline_; }
  std::vector<pollfd>& entries() { return entries_; }

 private:
  std::vector<pollfd> entries_;
  base::RunTime deadline_ = kNever;
};

/// Packets whose arrival the kernel has stamped, since the link began: how many, and how long they
/// waited to be read, all together.
struct Arrivals {
  std::uint64_t packets = 0;
  base::Duration waited{};
};

/// One communication path: opens itself, reads packets into the router, reopens itself after every
/// trouble. All calls but those of port() come on the thread of its loop and never block.
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
