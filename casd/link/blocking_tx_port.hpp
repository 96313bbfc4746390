// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "casd/link/tx_port.hpp"

namespace cas::casd {

/// threads: blocking, the traditional way of [HILS]: write a packet, wait until the line has it.
/// One thread serves all links. The main thread delivers the packets of casd's own station, and
/// waits while the other writes.
class BlockingTxPort final : public TxPort {
 public:
  /// @param drain  how the wait for a paced line ends
  BlockingTxPort(const TxPortOptions& options, LineDrain drain,
                 std::shared_ptr<LinkCounters> counters, std::function<void()> wake);

  void deliver(std::span<const PacketRef> packets, base::RunTime now) override;
  void carry_on(base::RunTime now) override;

 private:
  void write_or_drop(const PacketRef& packet);
  bool write_one(const PacketRef& packet);

  const LineDrain drain_;
};

}  // namespace cas::casd
