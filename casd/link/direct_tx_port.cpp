// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/direct_tx_port.hpp"

#include <atomic>
#include <utility>

namespace cas::casd {
namespace {

std::int64_t ns(base::RunTime time) { return time.time_since_epoch().count(); }

}  // namespace

DirectTxPort::DirectTxPort(const TxPortOptions& options, std::shared_ptr<LinkCounters> counters,
                           std::function<void()> wake)
    : TxPort(options, LinePacer::kSlack, std::move(counters), std::move(wake)) {}

void DirectTxPort::deliver(std::span<const PacketRef> packets, base::RunTime now) {
  std::size_t done = 0;
  if (!backlog_.load(std::memory_order_acquire) && writer_mutex_.try_lock()) {
    const base::MutexLock lock(writer_mutex_, std::adopt_lock);
    if (!backlog_.load(std::memory_order_relaxed)) {
      const std::span<const PacketRef> fresh = worth_sending(packets, now);
      const std::size_t gone = write_direct(fresh, now);
      if (gone < fresh.size()) enqueue(fresh.subspan(gone), now);
      done = packets.size();
    }
  }
  if (done < packets.size()) enqueue(packets.subspan(done), now);
  pump(now);
}

void DirectTxPort::carry_on(base::RunTime now) {
  {
    const base::MutexLock lock(writer_mutex_);
    drain(now);
  }
  pump(now);
}

// No lost wake-up: the queue is looked at again after the writer's lock was let go. A producer that
// failed to take the lock has queued before that look: the fence keeps the order of both.
void DirectTxPort::pump(base::RunTime now) {
  for (;;) {
    std::atomic_thread_fence(std::memory_order_seq_cst);
    if (!backlog_.load(std::memory_order_acquire) || !anything_queued()) return;
    if (wants_room() || held_by_pacer(now) || broken()) return;  // the link's thread carries on
    if (!writer_mutex_.try_lock()) return;
    const base::MutexLock lock(writer_mutex_, std::adopt_lock);
    drain(now);
  }
}

bool DirectTxPort::held_by_pacer(base::RunTime now) const {
  return due_ns_.load(std::memory_order_relaxed) > ns(now);
}

// The lock is held and nothing waits. @return how many packets are gone (or begun)
std::size_t DirectTxPort::write_direct(std::span<const PacketRef> packets, base::RunTime now) {
  if (!writer_ || packets.empty()) return 0;
  if (stands_still(now)) {
    wait_for_reader(now);
    return 0;
  }
  if (!pacer_.limited()) return write_some(packets, now);
  std::size_t done = 0;
  while (done < packets.size() && line_ready(now)) {
    if (write_some(packets.subspan(done, 1), now) == 0) return done;
    ++done;
  }
  return done;
}

void DirectTxPort::drain(base::RunTime now) {
  if (!writer_) return drop_all(DropCause::kClosed, now);
  if (broken()) return;
  busy_.store(false, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  if (!write_tail(now)) wait_for_room(now);
  if (stands_still(now)) return wait_for_reader(now);
  if (has_tail()) return;
  drop_late_batch(now);
  while (take_batch(now)) {
    const std::span<const PacketRef> rest = std::span(batch_).subspan(batch_at_);
    batch_at_ += write_some(rest, now);
    if (batch_at_ < batch_.size() || has_tail()) return;  // wait_for_room() was called
  }
  if (!busy_.load(std::memory_order_relaxed)) busy_since_ns_.store(0, std::memory_order_relaxed);
}

void DirectTxPort::wait_for_reader(base::RunTime now) {
  due_ns_.store(ns(tend_still_line(now)), std::memory_order_relaxed);
  wake_();
}

// Packets that were taken from the queue and found no room have aged since.
void DirectTxPort::drop_late_batch(base::RunTime now) {
  if (batch_at_ == batch_.size()) return;
  const auto late = [&](const PacketRef& packet) CAS_REQUIRES(writer_mutex_) {
    if (!options_.queue.too_late(*packet.info, packet.bytes.size(), now, pacer_)) return false;
    count_drop(*packet.info, DropCause::kAge, now);
    return true;
  };
  batch_.erase(batch_.begin(), batch_.begin() + static_cast<std::ptrdiff_t>(batch_at_));
  batch_at_ = 0;
  std::erase_if(batch_, late);
}

}  // namespace cas::casd
