// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "base/time/clock.hpp"

namespace cas::casd {

/// When tcdrain(3) on a UART lets its caller go on (`threads: blocking`). Linux is woken when its
/// own buffer is empty, that is with one FIFO of bytes still to go, and from then on looks whether
/// the last bit is out: between two looks it sleeps for the rest of the clock tick and a whole one
/// (serial core, uart_wait_until_sent; kernels 4.8 to 6.12 sleep a tick longer still).
class LineDrain {
 public:
  static constexpr std::size_t kFifoBytes = 16;  ///< of a 16550
  /// The fastest tick that Linux is built with, CONFIG_HZ=1000; Debian's has 4 ms.
  static constexpr base::Duration kDefaultTick = std::chrono::milliseconds(1);
  /// Ten times as fast as any; between two looks at the line some time has to pass.
  static constexpr base::Duration kLeastTick = std::chrono::microseconds(100);

  /// @param tick  of the kernel's clock; 0: woken the moment the last bit is out
  explicit LineDrain(base::Duration tick = kDefaultTick) : tick_(tick) {}

  /// @param written    when the packet was handed over
  /// @param sent       when its last bit is out
  /// @param fifo_time  that the line takes for kFifoBytes
  base::RunTime done(base::RunTime written, base::RunTime sent, base::Duration fifo_time) const {
    if (tick_ <= base::Duration{}) return std::max(written, sent);
    base::RunTime look = std::max(written, sent - fifo_time);
    while (look < sent) look = base::RunTime{(look.time_since_epoch() / tick_ + 2) * tick_};
    return look;
  }

 private:
  base::Duration tick_;
};

}  // namespace cas::casd
