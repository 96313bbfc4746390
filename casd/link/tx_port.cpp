// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/tx_port.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/os/log.hpp"
#include "casd/packet/setpoint_stream.hpp"
#include "casd/signing/link_signing.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::casd {
namespace {

std::int64_t ns(base::RunTime time) { return time.time_since_epoch().count(); }

// Most that is taken from the queue at once: it can no longer be overtaken, so it stays at what a
// PTY or a socket takes in one go.
constexpr std::size_t kBatchBytes = 4096;
constexpr std::size_t kBatchPackets = 64;

// A reader that is only busy is no standstill.
constexpr base::Duration kShortestStandstill = std::chrono::milliseconds(10);

}  // namespace

TxPort::TxPort(const TxPortOptions& options, base::Duration pacer_slack,
               std::shared_ptr<LinkCounters> counters, std::function<void()> wake)
    : options_(options),
      pacer_slack_(pacer_slack),
      counters_(std::move(counters)),
      wake_(std::move(wake)),
      line_check_(options.flow_control),
      standstill_(std::max(options.queue.hil_max_age, kShortestStandstill)),
      queue_(options.queue, [this](const PacketInfo& info, DropCause cause) CAS_REQUIRES(
                                queue_mutex_) { count_drop(info, cause, queue_time_); }) {
  pace(options.line_bytes_s);
}

void TxPort::attach(std::unique_ptr<PacketWriter> writer, base::RunTime now,
                    std::optional<double> line_bytes_s) {
  const base::MutexLock lock(writer_mutex_);
  drop_all(DropCause::kClosed, now);
  writer_ = options_.signing ? options_.signing->wrap(std::move(writer)) : std::move(writer);
  pace(line_bytes_s.value_or(options_.line_bytes_s));
  line_check_.reset();
  standstill_ = Standstill(standstill_.patience());
  broken_.store(false, std::memory_order_relaxed);
  open_.store(true, std::memory_order_release);
}

void TxPort::detach(base::RunTime now, DropCause cause) {
  const base::MutexLock lock(writer_mutex_);
  open_.store(false, std::memory_order_release);
  drop_all(cause, now);
  writer_.reset();
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

void TxPort::enqueue(std::span<const PacketRef> packets, base::RunTime now) {
  const base::MutexLock lock(queue_mutex_);
  queue_time_ = now;
  const bool open = open_.load(std::memory_order_acquire);
  for (const PacketRef& packet : packets) {
    if (open) {
      queue_.push(*packet.info, packet.bytes);
    } else {
      count_drop(*packet.info, DropCause::kClosed, now);
    }
  }
  if (!queue_.empty()) backlog_.store(true, std::memory_order_release);
  counters_->tx.queue_high_water.set(queue_.high_water());
  counters_->tx.queued.set(queue_.count());
}

void TxPort::drop_all(DropCause cause, base::RunTime now) {
  const base::MutexLock lock(queue_mutex_);
  queue_time_ = now;
  for (; batch_at_ < batch_.size(); ++batch_at_) count_drop(*batch_[batch_at_].info, cause, now);
  queue_.clear(cause);
  drop_tail(cause, now);
  backlog_.store(false, std::memory_order_release);
  busy_.store(false, std::memory_order_relaxed);
  busy_since_ns_.store(0, std::memory_order_relaxed);
  due_ns_.store(0, std::memory_order_relaxed);
  counters_->tx.queued.set(0);
}

// Held to the line's rate or to the cap, whichever is less.
void TxPort::pace(double line) {
  const double cap = options_.cap_bytes_s;
  const bool capped = cap > 0 && (line == 0 || cap < line);
  capped_.store(capped, std::memory_order_relaxed);
  pacer_ = LinePacer(capped ? cap : line, pacer_slack_);
  pacer_.set_sensor_gap(options_.sensor_gap);
}

void TxPort::count_drop(const PacketInfo& info, DropCause cause, base::RunTime now) {
  const bool by_cap = cause == DropCause::kAge && capped_.load(std::memory_order_relaxed);
  counters_->count_dropped(info, by_cap ? DropCause::kBandwidth : cause, now);
}

bool TxPort::anything_queued() {
  const base::MutexLock lock(queue_mutex_);
  return !queue_.empty();
}

std::size_t TxPort::write_some(std::span<const PacketRef> given, base::RunTime now) {
  const auto packets = options_.own_numbers ? own_numbers_.number(given) : given;
  const WriteResult result = writer_->write(packets);
  counters_->tx.write_calls.add();
  std::size_t gone = result.packets;
  settle(packets.first(gone), result, now);
  if (result.part_of_next > 0) begin_tail(packets[gone++], result.part_of_next, now);
  if (packets.data() != given.data()) own_numbers_.sent(packets.first(gone));
  if (result.broken) {
    broken_.store(true, std::memory_order_relaxed);
    wake_();
  } else if (gone < packets.size() || has_tail()) {
    if (gone > 0) busy_since_ns_.store(0, std::memory_order_relaxed);
    wait_for_room(now);
  }
  return gone;
}

// The begun packet takes the line from now on, and counts as sent once it is whole.
void TxPort::begin_tail(const PacketRef& packet, std::size_t gone, base::RunTime now) {
  tail_packet_.assign(packet.bytes.begin(), packet.bytes.end());
  tail_at_ = gone;
  tail_info_ = *packet.info;
  tail_spoilt_ = false;
  take_line({&packet, 1}, now);
}

void TxPort::drop_tail(DropCause cause, base::RunTime now) {
  if (has_tail() && !tail_spoilt_) count_drop(tail_info_, cause, now);
  tail_packet_.clear();
  tail_at_ = 0;
}

bool TxPort::write_tail(base::RunTime now) {
  if (!has_tail()) return true;
  spoil_late_tail(now);
  const WriteResult result = writer_->write_rest(std::span(tail_packet_).subspan(tail_at_));
  if (result.broken) {
    broken_.store(true, std::memory_order_relaxed);
    wake_();
    return false;
  }
  if (result.part_of_next > 0) busy_since_ns_.store(ns(now), std::memory_order_relaxed);
  tail_at_ += result.part_of_next;
  if (has_tail()) return false;
  const PacketRef whole{&tail_info_, tail_packet_};
  if (!tail_spoilt_) counters_->count_sent({&whole, 1}, now, std::max(result.done, now));
  return true;
}

bool TxPort::take_batch(base::RunTime now) {
  if (batch_at_ < batch_.size()) return true;
  batch_.clear();
  batch_infos_.clear();
  batch_bytes_.clear();
  batch_at_ = 0;
  const base::MutexLock lock(queue_mutex_);
  if (queue_.empty()) {
    backlog_.store(false, std::memory_order_release);
    return false;
  }
  if (!line_ready(now)) {
    wait_for_line();
    return false;
  }
  queue_time_ = now;
  const std::size_t most = pacer_.limited() ? 1 : kBatchPackets;
  batch_.reserve(kBatchPackets);  // all of them before a packet leaves the queue
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

// The pacer predicts when the line is free; the driver reports bytes still unsent. Wait for the
// later.
bool TxPort::line_ready(base::RunTime now) {
  if (!pacer_.limited()) return true;
  if (!pacer_.ready(now)) return false;
  pacer_.holds(line_check_.believed(writer_ ? writer_->unsent() : 0, now), now);
  return pacer_.ready(now);
}

// The packets between the unsent ones were sent.
void TxPort::settle(std::span<const PacketRef> done, const WriteResult& result, base::RunTime now) {
  counters_->count_tx_refused(result.refused_earlier);
  std::size_t begin = 0;
  for (const Unsent& unsent : result.unsent) {
    const std::size_t at = unsent.index;
    if (at > begin) account(done.subspan(begin, at - begin), now, result.done);
    if (unsent.cause) count_drop(*done[at].info, *unsent.cause, now);
    begin = at + 1;
  }
  if (done.size() > begin) account(done.subspan(begin), now, result.done);
}

void TxPort::account(std::span<const PacketRef> written, base::RunTime now, base::RunTime done) {
  take_line(written, now);
  counters_->count_sent(written, now, std::max(done, now));
}

void TxPort::take_line(std::span<const PacketRef> written, base::RunTime now) {
  std::size_t bytes = 0;
  for (const PacketRef& packet : written) {
    bytes += packet.bytes.size() + writer_->added_bytes();
    if (packet.info->message_id == mavlink::common::HilSensor::kId) pacer_.sent_sensor(now);
  }
  standstill_.given(now);
  pacer_.sent(bytes, now);
  line_check_.wrote(now);
}

void TxPort::wait_for_room(base::RunTime now) {
  backlog_.store(true, std::memory_order_release);
  if (busy_since_ns_.load(std::memory_order_relaxed) == 0) {
    busy_since_ns_.store(ns(now), std::memory_order_relaxed);
  }
  busy_.store(true, std::memory_order_relaxed);
  wake_();
}

// A packet that was begun is finished, so that the next one is found; one that has become too old
// meanwhile with a checksum or a signature that is wrong.
void TxPort::spoil_late_tail(base::RunTime now) {
  if (tail_spoilt_) return;
  if (!options_.queue.too_late(tail_info_, tail_packet_.size() - tail_at_, now, pacer_)) return;
  tail_packet_.back() ^= 0xFFU;
  writer_->spoil_rest();
  tail_spoilt_ = true;
  count_drop(tail_info_, DropCause::kAge, now);
}

bool TxPort::stands_still(base::RunTime now) {
  if (!standstill_.pending() || standstill_.rests(now)) return false;
  if (standstill_.look_begins(now)) {
    writer_->watch(true);
    return false;
  }
  if (!writer_->moved()) return standstill_.lasts(now) > patience(now);
  writer_->watch(false);
  if (standstill_.ended(now)) base::log::info("link " + counters_->name + ": moves again");
  if (has_tail()) standstill_.given(now);  // its rest waits for the next move
  return false;
}

// A peer that still sends has perhaps read unseen, where nothing counts its reads: it gets more
// time. But not without end, because a board whose receiver hangs may send for ever.
base::Duration TxPort::patience(base::RunTime now) const {
  constexpr int kWithAPeerThatSpeaks = 4;
  const base::Duration patience = standstill_.patience();
  const bool speaks = ns(now) - heard_ns_.load(std::memory_order_relaxed) < patience.count();
  return speaks && !writer_->counts_moves() ? kWithAPeerThatSpeaks * patience : patience;
}

void TxPort::heard(base::RunTime now) { heard_ns_.store(ns(now), std::memory_order_relaxed); }

base::RunTime TxPort::tend_still_line(base::RunTime now) {
  if (standstill_.flush_is_due(now)) {
    base::log::warn("link " + counters_->name + ": stands still, gets nothing until it moves");
    if (writer_->flush()) drop_tail(DropCause::kStalled, now);
  }
  if (!has_tail() && standstill_.nudge_is_due(now)) writer_->nudge();
  return standstill_.next_look(now);
}

std::span<const PacketRef> TxPort::worth_sending(std::span<const PacketRef> packets,
                                                 base::RunTime now) {
  const auto is_setpoint = [](const PacketRef& packet) {
    return packet.info->traffic == TrafficClass::kSetpoint;
  };
  const bool waited = std::any_of(packets.begin(), packets.end(), [](const PacketRef& packet) {
    return packet.info->waited > base::Duration{};
  });
  const bool alone = packets.size() == 1;
  if (!waited && (alone || std::count_if(packets.begin(), packets.end(), is_setpoint) < 2)) {
    return packets;
  }
  worth_sending_.clear();
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const PacketRef& packet = packets[i];
    const auto takes_its_place = [&](const PacketRef& newer) {
      return same_stream(*packet.info, *newer.info) &&
             replaces(*packet.info, newer.bytes, packet.bytes);
    };
    const auto newer = packets.subspan(i + 1);
    if (options_.queue.too_late(*packet.info, packet.bytes.size(), now, pacer_)) {
      count_drop(*packet.info, DropCause::kAge, now);
    } else if (is_setpoint(packet) && std::any_of(newer.begin(), newer.end(), takes_its_place)) {
      count_drop(*packet.info, DropCause::kSuperseded, now);
    } else {
      worth_sending_.push_back(packet);
    }
  }
  return worth_sending_;
}

void TxPort::wait_for_line() {
  due_ns_.store(ns(pacer_.ready_at()), std::memory_order_relaxed);
  wake_();
}

}  // namespace cas::casd
