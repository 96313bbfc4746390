// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tx_port.hpp"

#include <poll.h>
#include <time.h>

#include <utility>

#include "casd/link_signing.hpp"

namespace cas::casd {
namespace {

// Most that is taken from the queue at once: it can no longer be reordered or dropped for age, so
// it stays at what a PTY or a socket takes in one go.
constexpr std::size_t kBatchBytes = 4096;
constexpr std::size_t kBatchPackets = 64;
// threads: blocking gives a line that takes nothing so long, then goes on.
constexpr int kBlockingPatience_ms = 1000;

constexpr std::uint32_t kHilSensorId = 107;

std::int64_t ns(base::RunTime time) { return time.time_since_epoch().count(); }

void sleep_until(base::RunTime when) {
  const std::int64_t total = ns(when);
  const timespec until{static_cast<time_t>(total / 1'000'000'000), total % 1'000'000'000};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

LinePacer make_pacer(const TxPortOptions& options) {
  LinePacer pacer(options.line_bytes_s, options.blocking ? base::Duration{} : LinePacer::kSlack);
  if (!options.blocking) pacer.set_sensor_gap(options.sensor_gap);
  return pacer;
}

}  // namespace

TxPort::TxPort(const TxPortOptions& options, std::shared_ptr<LinkMonitor> monitor,
               std::function<void()> wake)
    : options_(options),
      monitor_(std::move(monitor)),
      wake_(std::move(wake)),
      pacer_(make_pacer(options)),
      queue_(options.queue,
             [this](const PacketInfo& info, DropCause cause) { count_drop(info, cause); }) {}

void TxPort::deliver(std::span<const PacketRef> packets, base::RunTime now) {
  if (options_.blocking) return deliver_blocking(packets);
  std::size_t done = 0;
  if (!backlog_.load(std::memory_order_acquire)) {
    const std::unique_lock lock(writer_mutex_, std::try_to_lock);
    if (lock && !backlog_.load(std::memory_order_relaxed)) {
      done = write_direct(packets, now);
      if (done < packets.size()) enqueue(packets.subspan(done));
      done = packets.size();
    }
  }
  if (done < packets.size()) enqueue(packets.subspan(done));
  pump(now);
}

void TxPort::attach(std::unique_ptr<PacketWriter> writer) {
  const std::scoped_lock lock(writer_mutex_);
  drop_all(DropCause::kDown);
  writer_ = options_.signing ? options_.signing->wrap(std::move(writer)) : std::move(writer);
  pacer_.reset();
  broken_.store(false, std::memory_order_relaxed);
  open_.store(true, std::memory_order_release);
}

void TxPort::detach(DropCause cause) {
  const std::scoped_lock lock(writer_mutex_);
  open_.store(false, std::memory_order_release);
  drop_all(cause);
  writer_.reset();
}

void TxPort::carry_on(base::RunTime now) {
  if (options_.blocking) return carry_on_blocking();
  {
    const std::scoped_lock lock(writer_mutex_);
    drain(now);
  }
  pump(now);
}

base::RunTime TxPort::due() const {
  const std::int64_t due = due_ns_.load(std::memory_order_relaxed);
  return due == 0 ? PollSet::kNever : base::RunTime(base::Duration(due));
}

std::optional<base::RunTime> TxPort::stuck_since() const {
  const std::int64_t since = busy_since_ns_.load(std::memory_order_relaxed);
  if (since == 0) return std::nullopt;
  return base::RunTime(base::Duration(since));
}

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

// One packet, then the time the line takes for it.
void TxPort::carry_on_blocking() {
  const std::scoped_lock lock(writer_mutex_);
  const base::RunTime start = base::steady_now();
  busy_.store(false, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  if (!take_batch(start)) return;
  for (; batch_at_ < batch_.size(); ++batch_at_) write_or_drop(batch_[batch_at_], start);
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
  if (pacer_.limited()) sleep_until(pacer_.arrival(0, start));
  if (anything_queued()) due_ns_.store(1, std::memory_order_relaxed);
}

void TxPort::write_or_drop(const PacketRef& packet, base::RunTime now) {
  if (write_one_blocking(packet, now)) return;
  const std::scoped_lock counting(queue_mutex_);
  count_drop(*packet.info, writer_ ? DropCause::kStalled : DropCause::kDown);
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

// The lock is held and nothing waits. @return how many packets are gone (or begun)
std::size_t TxPort::write_direct(std::span<const PacketRef> packets, base::RunTime now) {
  if (!writer_) return 0;
  if (!pacer_.limited()) return write_some(packets, now);
  std::size_t done = 0;
  while (done < packets.size() && pacer_.ready(now)) {
    if (write_some(packets.subspan(done, 1), now) == 0) return done;
    ++done;
  }
  return done;
}

std::size_t TxPort::write_some(std::span<const PacketRef> packets, base::RunTime now) {
  const WriteResult result = writer_->write(packets);
  monitor_->tx.write_calls.add();
  std::size_t gone = result.packets;
  if (result.part_of_next > 0) {
    const auto rest = packets[gone].bytes.subspan(result.part_of_next);
    tail_.assign(rest.begin(), rest.end());
    ++gone;
  }
  if (gone > 0) account(packets.first(gone), now);
  if (result.broken) {
    broken_.store(true, std::memory_order_relaxed);
    wake_();
  } else if (gone < packets.size() || !tail_.empty()) {
    if (gone > 0) busy_since_ns_.store(0, std::memory_order_relaxed);
    wait_for_room(now);
  }
  return gone;
}

void TxPort::enqueue(std::span<const PacketRef> packets) {
  const std::scoped_lock lock(queue_mutex_);
  const bool open = open_.load(std::memory_order_acquire);
  for (const PacketRef& packet : packets) {
    if (open) {
      queue_.push(*packet.info, packet.bytes);
    } else {
      count_drop(*packet.info, DropCause::kDown);
    }
  }
  if (!queue_.empty()) backlog_.store(true, std::memory_order_release);
  monitor_->tx.queue_high_water.set(queue_.high_water());
  monitor_->tx.queued.set(queue_.count());
}

// Whoever finds packets waiting and nobody writing writes them. The look at the queue comes after
// the writer's lock was let go, so between the two of us one sees what the other left.
void TxPort::pump(base::RunTime now) {
  while (anything_queued()) {
    if (wants_room() || held_by_pacer(now) || broken()) return;  // the link's thread carries on
    const std::unique_lock lock(writer_mutex_, std::try_to_lock);
    if (!lock) return;
    drain(now);
  }
}

bool TxPort::held_by_pacer(base::RunTime now) const {
  return due_ns_.load(std::memory_order_relaxed) > ns(now);
}

void TxPort::drain(base::RunTime now) {
  if (!writer_) return drop_all(DropCause::kDown);
  if (broken()) return;
  busy_.store(false, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  if (!write_tail(now)) return wait_for_room(now);
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
  if (!pacer_.ready(now)) {
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
  monitor_->tx.queued.set(queue_.count());
  if (batch_.empty()) backlog_.store(false, std::memory_order_release);
  return !batch_.empty();
}

void TxPort::drop_all(DropCause cause) {
  const std::scoped_lock lock(queue_mutex_);
  for (; batch_at_ < batch_.size(); ++batch_at_) count_drop(*batch_[batch_at_].info, cause);
  queue_.clear(cause);
  tail_.clear();
  backlog_.store(false, std::memory_order_release);
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  monitor_->tx.queued.set(0);
}

void TxPort::account(std::span<const PacketRef> written, base::RunTime now) {
  std::size_t bytes = 0;
  for (const PacketRef& packet : written) {
    bytes += packet.bytes.size() + writer_->added_bytes();
    monitor_->tx.messages.add(packet.info->message_id, packet.info->source, now);
    if (packet.info->message_id == kHilSensorId) pacer_.sent_sensor(now);
  }
  pacer_.sent(bytes, now);
  monitor_->tx.packets.add(written.size());
  monitor_->tx.bytes.add(bytes);
  const base::RunTime done = base::steady_now();
  if (monitor_->ledger) {
    for (const PacketRef& packet : written) monitor_->ledger->sent(*packet.info, done);
  }
  const std::scoped_lock lock(monitor_->tx.forwarding_mutex);
  for (const PacketRef& packet : written) {
    const base::Duration time = done - packet.info->received;
    monitor_->tx.forwarding.add(time);
    monitor_->tx.routes.add(packet.info->from, time);
  }
}

// queue_mutex_ is held: it makes the one writer of these counters.
void TxPort::count_drop(const PacketInfo& info, DropCause cause) {
  const auto index = static_cast<std::size_t>(cause);
  monitor_->tx.dropped[index].add();
  monitor_->tx.dropped_messages[index].add(info.message_id, info.source, info.received);
  if (monitor_->ledger) monitor_->ledger->dropped(info, cause, base::steady_now());
}

bool TxPort::anything_queued() {
  const std::scoped_lock lock(queue_mutex_);
  return !queue_.empty();
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
