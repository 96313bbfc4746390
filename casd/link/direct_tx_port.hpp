// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>

#include "casd/link/tx_port.hpp"

namespace cas::casd {

/// Several threads write to one descriptor (all `threads` but blocking).
///
///   receiving link's thread                      destination's own thread
///   deliver: try the writer's lock
///     free, nothing waits -> write at once
///     taken or line busy  -> queue ----------->  carry_on, when the descriptor or the pacer is
///                                                ready: queue -> write
///
/// Who holds the writer's lock looks at the queue again after letting go, so a packet that was
/// queued meanwhile never waits for a wake-up.
class DirectTxPort final : public TxPort {
 public:
  /// @param wake  called when the link's thread must call carry_on(); from any thread
  DirectTxPort(const TxPortOptions& options, std::shared_ptr<LinkCounters> counters,
               std::function<void()> wake);

  void deliver(std::span<const PacketRef> packets, base::RunTime now) override;
  void carry_on(base::RunTime now) override;

 private:
  std::size_t write_direct(std::span<const PacketRef> packets, base::RunTime now)
      CAS_REQUIRES(writer_mutex_);
  void pump(base::RunTime now);
  void drain(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  void wait_for_reader(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  void drop_late_batch(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  bool held_by_pacer(base::RunTime now) const;
};

}  // namespace cas::casd
