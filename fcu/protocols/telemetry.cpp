// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry.hpp"

#include <algorithm>
#include <cmath>

#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/heartbeat.hpp"

namespace cas::fcu {

namespace {

/// Sent at once when arming state, mode or landed state change.
constexpr std::uint32_t kHurriedIds[] = {mavlink::common::Heartbeat::kId,
                                         mavlink::common::ExtendedSysState::kId};

/// First update: streams start spread over their intervals instead of all at once.
constexpr base::Duration kSpread = std::chrono::microseconds(1700);
constexpr base::Duration kShortestInterval = std::chrono::milliseconds(2);
constexpr double kLongestInterval_us = 1e9;

}  // namespace

Telemetry::Telemetry(const FcuCore& core, Outbox& outbox) : core_(core), outbox_(outbox) {
  base::Duration offset{};
  for (const MessageSource& source : message_sources()) {
    Stream stream;
    stream.id = source.id;
    stream.usual = source.rate_hz > 0 ? base::from_seconds(1.0 / source.rate_hz) : base::Duration{};
    stream.interval = stream.usual;
    stream.send = source.send;
    stream.next = base::RunTime(offset);
    offset += kSpread;
    streams_.push_back(stream);
  }
}

Telemetry::Stream* Telemetry::find(std::uint32_t id) {
  for (Stream& stream : streams_) {
    if (stream.id == id) return &stream;
  }
  return nullptr;
}

void Telemetry::update(base::RunTime now) {
  if (hurry_) {
    hurry_ = false;
    for (const std::uint32_t id : kHurriedIds) send_now(id, now, 2);
  }
  if (now < next_due_) return;
  next_due_ = now + std::chrono::seconds(1);
  for (Stream& stream : streams_) {
    if (stream.interval <= base::Duration{}) continue;
    if (stream.next < now - stream.interval) stream.next = now;  // never catch up in a burst
    if (stream.next <= now) {
      stream.send({core_, outbox_, now});
      stream.next += stream.interval;
    }
    next_due_ = std::min(next_due_, stream.next);
  }
}

Telemetry::Sent Telemetry::send_now(std::uint32_t id, base::RunTime now, int version) {
  Stream* stream = find(id);
  if (stream == nullptr) return Sent::kUnknown;
  const std::uint64_t before = outbox_.counts()[id];
  stream->send({core_, outbox_, now, version});
  return outbox_.counts()[id] > before ? Sent::kSent : Sent::kNothingYet;
}

bool Telemetry::set_interval(std::uint32_t id, double interval_us) {
  Stream* stream = find(id);
  if (stream == nullptr || !std::isfinite(interval_us)) return false;
  if (interval_us < 0) {
    stream->interval = base::Duration{};
  } else if (interval_us == 0) {
    stream->interval = stream->usual;
  } else {
    const double wanted_us = std::min(interval_us, kLongestInterval_us);
    stream->interval = std::max(base::from_seconds(wanted_us * 1e-6), kShortestInterval);
  }
  next_due_ = {};
  return true;
}

std::int32_t Telemetry::interval_us(std::uint32_t id) const {
  for (const Stream& stream : streams_) {
    if (stream.id != id) continue;
    if (stream.interval <= base::Duration{}) return -1;
    return static_cast<std::int32_t>(stream.interval.count() / 1000);
  }
  return 0;
}

}  // namespace cas::fcu
