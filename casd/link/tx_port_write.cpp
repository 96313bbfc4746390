// SPDX-License-Identifier: BSD-3-Clause
// The part of TxPort that writes: whoever is here holds writer_mutex_.
#include "casd/link/tx_port.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::casd {
namespace {

// Most that is taken from the queue at once: it can no longer be overtaken, so it stays at what a
// PTY or a socket takes in one go.
constexpr std::size_t kBatchBytes = 4096;
constexpr std::size_t kBatchPackets = 64;

std::int64_t ns(base::RunTime time) { return time.time_since_epoch().count(); }

}  // namespace

// The lock is held and nothing waits. @return how many packets are gone (or begun)
std::size_t TxPort::write_direct(std::span<const PacketRef> packets, base::RunTime now) {
  if (!writer_) return 0;
  if (!pacer_.limited()) return write_some(packets, now);
  std::size_t done = 0;
  while (done < packets.size() && line_ready(now)) {
    if (write_some(packets.subspan(done, 1), now) == 0) return done;
    ++done;
  }
  return done;
}

std::size_t TxPort::write_some(std::span<const PacketRef> packets, base::RunTime now) {
  const WriteResult result = writer_->write(packets);
  counters_->tx.write_calls.add();
  std::size_t gone = result.packets;
  if (result.part_of_next > 0) {
    const auto rest = packets[gone].bytes.subspan(result.part_of_next);
    tail_.assign(rest.begin(), rest.end());
    ++gone;
  }
  settle(packets.first(gone), result.unsignable, now);
  if (result.broken) {
    broken_.store(true, std::memory_order_relaxed);
    wake_();
  } else if (gone < packets.size() || !tail_.empty()) {
    if (gone > 0) busy_since_ns_.store(0, std::memory_order_relaxed);
    wait_for_room(now);
  }
  return gone;
}

void TxPort::drain(base::RunTime now) {
  if (!writer_) return drop_all(DropCause::kClosed);
  if (broken()) return;
  busy_.store(false, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  if (!write_tail(now)) return wait_for_room(now);
  drop_late_batch(now);
  while (take_batch(now)) {
    const std::span<const PacketRef> rest = std::span(batch_).subspan(batch_at_);
    batch_at_ += write_some(rest, now);
    if (batch_at_ < batch_.size() || !tail_.empty()) return;  // wait_for_room() was called
  }
  if (!busy_.load(std::memory_order_relaxed)) busy_since_ns_.store(0, std::memory_order_relaxed);
}

// @return true when no begun packet is left
bool TxPort::write_tail(base::RunTime now) {
  if (tail_.empty()) return true;
  const std::ptrdiff_t gone = writer_->write_rest(tail_);
  if (gone < 0) {
    broken_.store(true, std::memory_order_relaxed);
    wake_();
    return false;
  }
  if (gone > 0) busy_since_ns_.store(ns(now), std::memory_order_relaxed);
  tail_.erase(tail_.begin(), tail_.begin() + gone);
  return tail_.empty();
}

// Fills the batch from the queue. @return false when nothing may be written now
bool TxPort::take_batch(base::RunTime now) {
  if (batch_at_ < batch_.size()) return true;
  batch_.clear();
  batch_infos_.clear();
  batch_bytes_.clear();
  batch_at_ = 0;
  const std::scoped_lock lock(queue_mutex_);
  if (queue_.empty()) {
    backlog_.store(false, std::memory_order_release);
    return false;
  }
  if (!line_ready(now)) {
    wait_for_line();
    return false;
  }
  const std::size_t most = pacer_.limited() ? 1 : kBatchPackets;
  batch_infos_.reserve(kBatchPackets);
  batch_bytes_.reserve(kBatchBytes + mav::kMaxPacketBytes);
  while (batch_.size() < most && batch_bytes_.size() < kBatchBytes) {
    const std::optional<QueuedPacket> next = queue_.pop(now, pacer_);
    if (!next) break;
    const std::size_t offset = batch_bytes_.size();
    batch_bytes_.insert(batch_bytes_.end(), next->bytes.begin(), next->bytes.end());
    batch_infos_.push_back(next->info);
    batch_.push_back({&batch_infos_.back(), {batch_bytes_.data() + offset, next->bytes.size()}});
  }
  counters_->tx.queued.set(queue_.count());
  if (batch_.empty()) backlog_.store(false, std::memory_order_release);
  return !batch_.empty();
}

// What was taken from the queue and found no room has aged since.
void TxPort::drop_late_batch(base::RunTime now) {
  if (batch_at_ == batch_.size()) return;
  const auto late = [&](const PacketRef& packet) {
    if (!queue_.too_late(*packet.info, packet.bytes.size(), now, pacer_)) return false;
    count_drop(*packet.info, DropCause::kAge);
    return true;
  };
  batch_.erase(batch_.begin(), batch_.begin() + static_cast<std::ptrdiff_t>(batch_at_));
  batch_at_ = 0;
  std::erase_if(batch_, late);
}

// The pacer reckons what the line should be through with; the driver knows what it is not.
bool TxPort::line_ready(base::RunTime now) {
  if (!pacer_.limited()) return true;
  if (!pacer_.ready(now)) return false;
  pacer_.holds(line_check_.believed(writer_ ? writer_->unsent() : 0, now), now);
  return pacer_.ready(now);
}

// What lies between the packets that cannot be signed is gone.
void TxPort::settle(std::span<const PacketRef> done, std::span<const std::size_t> unsignable,
                    base::RunTime now) {
  std::size_t begin = 0;
  for (const std::size_t at : unsignable) {
    if (at > begin) account(done.subspan(begin, at - begin), now);
    count_drop(*done[at].info, DropCause::kUnsignable);
    begin = at + 1;
  }
  if (done.size() > begin) account(done.subspan(begin), now);
}

void TxPort::account(std::span<const PacketRef> written, base::RunTime now) {
  std::size_t bytes = 0;
  for (const PacketRef& packet : written) {
    bytes += packet.bytes.size() + writer_->added_bytes();
    if (packet.info->message_id == mavlink::common::HilSensor::kId) pacer_.sent_sensor(now);
  }
  pacer_.sent(bytes, now);
  line_check_.wrote(now);
  counters_->count_sent(written, now, base::steady_now());
}

void TxPort::wait_for_room(base::RunTime now) {
  backlog_.store(true, std::memory_order_release);
  if (busy_since_ns_.load(std::memory_order_relaxed) == 0) {
    busy_since_ns_.store(ns(now), std::memory_order_relaxed);
  }
  busy_.store(true, std::memory_order_relaxed);
  wake_();
}

void TxPort::wait_for_line() {
  due_ns_.store(ns(pacer_.ready_at()), std::memory_order_relaxed);
  wake_();
}

}  // namespace cas::casd
