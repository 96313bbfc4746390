// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "casd/link/tx_port.hpp"

namespace cas::casd {

/// The thread of `threads: blocking` gives up on the rest of a packet after this silence.
inline constexpr base::Duration kBlockingPatience = std::chrono::milliseconds(20);

/// How the thread of `threads: blocking` waits, and the time that it has: the steady clock's, or
/// that of a simulation.
class LineWait {
 public:
  virtual ~LineWait() = default;
  virtual base::RunTime now() const = 0;
  virtual void until(base::RunTime when) = 0;
  /// Waits until the descriptor takes bytes, at most so long.
  virtual void for_room(int descriptor, base::Duration at_most) = 0;
};

/// threads: blocking, the traditional way of [HILS]: write a packet, wait until the line has it.
/// One thread serves all links. The main thread delivers the packets of casd's own station, and
/// waits while the other writes.
///
/// Time passes inside its calls, so it asks `wait` for it instead of taking an argument.
class BlockingTxPort final : public TxPort {
 public:
  /// @param drain  how the wait for a paced line ends
  /// @param wait   outlives the port
  BlockingTxPort(const TxPortOptions& options, LineDrain drain, LineWait& wait,
                 std::shared_ptr<LinkCounters> counters, std::function<void()> wake);

  void deliver(std::span<const PacketRef> packets, base::RunTime now) override;
  void carry_on(base::RunTime now) override;

 private:
  void write_or_drop(const PacketRef& packet) CAS_REQUIRES(writer_mutex_);
  bool write_one(const PacketRef& packet) CAS_REQUIRES(writer_mutex_);

  const LineDrain drain_;
  LineWait& wait_;
};

}  // namespace cas::casd
