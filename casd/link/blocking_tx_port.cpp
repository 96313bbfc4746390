// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/blocking_tx_port.hpp"

#include <chrono>
#include <utility>

namespace cas::casd {
namespace {

// A line that takes nothing so long loses the packet.
constexpr base::Duration kPatience = std::chrono::seconds(1);
constexpr base::Duration kStep = std::chrono::milliseconds(100);
// A line that stands still may have room, and must be looked at.
constexpr base::Duration kLook = std::chrono::milliseconds(2);

// The wait for the line takes the place of sensor gap and slack.
TxPortOptions without_gap(TxPortOptions options) {
  options.sensor_gap = {};
  return options;
}

}  // namespace

BlockingTxPort::BlockingTxPort(const TxPortOptions& options, LineDrain drain, LineWait& wait,
                               std::shared_ptr<LinkCounters> counters, std::function<void()> wake)
    : TxPort(without_gap(options), base::Duration{}, std::move(counters), std::move(wake)),
      drain_(drain),
      wait_(wait) {}

// A line without a rate is written to at once; for a paced one the packets wait in the same queue
// as in the other thread models, and each turn of the loop writes one.
void BlockingTxPort::deliver(std::span<const PacketRef> packets, base::RunTime now) {
  const base::MutexLock lock(writer_mutex_);
  if (pacer_.limited()) {
    enqueue(packets, now);
    due_ns_.store(1, std::memory_order_relaxed);  // at once
    return wake_();
  }
  for (const PacketRef& packet : worth_sending(packets, wait_.now())) write_or_drop(packet);
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
}

// One packet, then the wait until the line is through with it.
void BlockingTxPort::carry_on(base::RunTime) {
  const base::MutexLock lock(writer_mutex_);
  const base::RunTime start = wait_.now();
  busy_.store(false, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  if (!take_batch(start)) return;
  for (; batch_at_ < batch_.size(); ++batch_at_) write_or_drop(batch_[batch_at_]);
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
  if (pacer_.limited()) {
    const base::Duration fifo_time = pacer_.time_for(LineDrain::kFifoBytes);
    wait_.until(drain_.done(start, pacer_.arrival(0, start), fifo_time));
  }
  if (anything_queued()) due_ns_.store(1, std::memory_order_relaxed);
}

void BlockingTxPort::write_or_drop(const PacketRef& packet) {
  if (write_one(packet)) return;
  const base::RunTime now = wait_.now();
  const bool late = options_.queue.too_late(*packet.info, packet.bytes.size(), now, pacer_);
  const DropCause why = writer_ ? DropCause::kStalled : DropCause::kClosed;
  count_drop(*packet.info, late ? DropCause::kAge : why, now);
}

// @return true when the packet is gone, or begun with its rest in the tail
bool BlockingTxPort::write_one(const PacketRef& packet) {
  bool begun = false;
  base::RunTime now = wait_.now();
  for (const base::RunTime deadline = now + kPatience; now < deadline; now = wait_.now()) {
    if (!writer_ || broken()) return begun;
    const bool still = stands_still(now);
    if (write_tail(now)) {
      if (begun) return true;
      if (options_.queue.too_late(*packet.info, packet.bytes.size(), now, pacer_)) return false;
      begun = !still && write_some({&packet, 1}, now) == 1;
      if (begun && !has_tail()) return true;
    }
    if (still) tend_still_line(now);
    still ? wait_.until(now + kLook) : wait_.for_room(writer_->descriptor(), kStep);
  }
  return begun;
}

}  // namespace cas::casd
