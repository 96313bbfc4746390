// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/tx_port.hpp"

#include <utility>

#include "casd/signing/link_signing.hpp"

namespace cas::casd {
namespace {

std::int64_t ns(base::RunTime time) { return time.time_since_epoch().count(); }

}  // namespace

TxPort::TxPort(const TxPortOptions& options, std::shared_ptr<LinkCounters> counters,
               std::function<void()> wake)
    : options_(options),
      counters_(std::move(counters)),
      wake_(std::move(wake)),
      line_check_(options.flow_control),
      queue_(options.queue,
             [this](const PacketInfo& info, DropCause cause) { count_drop(info, cause); }) {
  pace(true);
}

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

void TxPort::attach(std::unique_ptr<PacketWriter> writer, bool has_rate) {
  const std::scoped_lock lock(writer_mutex_);
  drop_all(DropCause::kClosed);
  writer_ = options_.signing ? options_.signing->wrap(std::move(writer)) : std::move(writer);
  pace(has_rate);
  line_check_.reset();
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

void TxPort::enqueue(std::span<const PacketRef> packets) {
  const std::scoped_lock lock(queue_mutex_);
  const bool open = open_.load(std::memory_order_acquire);
  for (const PacketRef& packet : packets) {
    if (open) {
      queue_.push(*packet.info, packet.bytes);
    } else {
      count_drop(*packet.info, DropCause::kClosed);
    }
  }
  if (!queue_.empty()) backlog_.store(true, std::memory_order_release);
  counters_->tx.queue_high_water.set(queue_.high_water());
  counters_->tx.queued.set(queue_.count());
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

void TxPort::drop_all(DropCause cause) {
  const std::scoped_lock lock(queue_mutex_);
  for (; batch_at_ < batch_.size(); ++batch_at_) count_drop(*batch_[batch_at_].info, cause);
  queue_.clear(cause);
  tail_.clear();
  backlog_.store(false, std::memory_order_release);
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  counters_->tx.queued.set(0);
}

// Held to the line's rate, to the cap, or to what is less.
void TxPort::pace(bool has_rate) {
  const double line = has_rate ? options_.line_bytes_s : 0;
  const double cap = options_.cap_bytes_s;
  const bool capped = cap > 0 && (line == 0 || cap < line);
  capped_.store(capped, std::memory_order_relaxed);
  pacer_ = LinePacer(capped ? cap : line, options_.blocking ? base::Duration{} : LinePacer::kSlack);
  if (!options_.blocking) pacer_.set_sensor_gap(options_.sensor_gap);
}

void TxPort::count_drop(const PacketInfo& info, DropCause cause) {
  const bool by_cap = cause == DropCause::kAge && capped_.load(std::memory_order_relaxed);
  counters_->count_dropped(info, by_cap ? DropCause::kBandwidth : cause);
}

bool TxPort::anything_queued() {
  const std::scoped_lock lock(queue_mutex_);
  return !queue_.empty();
}

}  // namespace cas::casd
