// SPDX-License-Identifier: BSD-3-Clause
// threads: blocking, the traditional way of [HILS]: write a packet, wait until the line has it.
#include <poll.h>
#include <time.h>

#include <cerrno>

#include "casd/link/tx_port.hpp"

namespace cas::casd {
namespace {

// A line that takes nothing so long loses the packet.
constexpr int kBlockingPatience_ms = 1000;

void sleep_until(base::RunTime when) {
  const std::int64_t total = when.time_since_epoch().count();
  const timespec until{static_cast<time_t>(total / 1'000'000'000), total % 1'000'000'000};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace

// A line without a rate is written to at once; for a paced one the packets wait in the same queue
// as in the other thread models, and each turn of the loop writes one.
void TxPort::deliver_blocking(std::span<const PacketRef> packets) {
  const std::scoped_lock lock(writer_mutex_);
  if (pacer_.limited()) {
    enqueue(packets);
    due_ns_.store(1, std::memory_order_relaxed);  // at once
    return wake_();
  }
  for (const PacketRef& packet : packets) write_or_drop(packet, base::steady_now());
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
}

// One packet, then the wait until the line is through with it.
void TxPort::carry_on_blocking() {
  const std::scoped_lock lock(writer_mutex_);
  const base::RunTime start = base::steady_now();
  busy_.store(false, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  if (!take_batch(start)) return;
  for (; batch_at_ < batch_.size(); ++batch_at_) write_or_drop(batch_[batch_at_], start);
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
  if (pacer_.limited()) {
    const base::Duration fifo_time = pacer_.time_for(LineDrain::kFifoBytes);
    sleep_until(options_.drain.done(start, pacer_.arrival(0, start), fifo_time));
  }
  if (anything_queued()) due_ns_.store(1, std::memory_order_relaxed);
}

void TxPort::write_or_drop(const PacketRef& packet, base::RunTime now) {
  if (write_one_blocking(packet, now)) return;
  count_drop(*packet.info, writer_ ? DropCause::kStalled : DropCause::kClosed);
}

// @return true when the packet is gone, or begun with its rest in the tail
bool TxPort::write_one_blocking(const PacketRef& packet, base::RunTime now) {
  constexpr int kStep_ms = 100;
  bool begun = false;
  for (int waited_ms = 0; waited_ms < kBlockingPatience_ms; waited_ms += kStep_ms) {
    if (!writer_ || broken()) return begun;
    if (write_tail(now)) {
      begun = begun || write_some({&packet, 1}, now) == 1;
      if (begun && tail_.empty()) return true;
    }
    pollfd room{writer_->descriptor(), POLLOUT, 0};
    ::poll(&room, 1, kStep_ms);
  }
  return begun;
}

}  // namespace cas::casd
