// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "base/time/clock.hpp"
#include "casd/packet/packet_info.hpp"

namespace cas::casd {

/// A packet on its way through, borrowed.
struct PacketRef {
  const PacketInfo* info = nullptr;
  std::span<const std::uint8_t> bytes;
};

/// Takes packets for one destination, from any thread, without blocking.
class PacketPort {
 public:
  virtual ~PacketPort() = default;
  virtual void deliver(std::span<const PacketRef> packets, base::RunTime now) = 0;
};

}  // namespace cas::casd
