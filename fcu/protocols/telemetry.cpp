// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry.hpp"

#include <algorithm>
#include <cmath>

#include "fcu/core/fcu_core.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/table.hpp"

namespace cas::fcu {

namespace {

/// Sent at once when arming state, mode or landed state change.
constexpr std::uint32_t kHurriedIds[] = {mavlink::common::Heartbeat::kId,
                                         mavlink::common::ExtendedSysState::kId};

/// First update: streams start spread over their intervals instead of all at once.
constexpr base::Duration kSpread = std::chrono::microseconds(1700);
constexpr base::Duration kShortestInterval = std::chrono::milliseconds(2);
constexpr double kLongestInterval_us = 1e9;

/// Streams of this interval and longer are not slowed down: a ground station lives on HEARTBEAT.
constexpr base::Duration kKept = std::chrono::seconds(1);
/// Least share of the usual rates: something is always sent, as with PX4.
constexpr double kLeastShare = 0.05;

/// Length of a MAVLink 2 packet without extensions and signature.
double packet_bytes(std::uint32_t id) {
  constexpr double kAroundPayload = 12;
  const mav::MessageInfo* info = mavlink::common::table().find(id);
  return info == nullptr ? 0 : info->min_length + kAroundPayload;
}

}  // namespace

Telemetry::Telemetry(const FcuCore& core, Outbox& outbox) : core_(core), outbox_(outbox) {
  base::Duration offset{};
  for (const MessageSource& source : message_sources()) {
    Stream stream;
    stream.id = source.id;
    stream.usual = source.rate_hz > 0 ? base::from_seconds(1.0 / source.rate_hz) : base::Duration{};
    stream.interval = stream.usual;
    stream.bytes = packet_bytes(source.id);
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
  share_line(now);
  next_due_ = now + std::chrono::seconds(1);
  Stream* first = nullptr;  // on a slow line
  for (Stream& stream : streams_) {
    if (stream.interval <= base::Duration{}) continue;
    if (stream.next < now - spacing(stream)) stream.next = now;  // never catch up in a burst
    if (stream.next <= now && share_ == 1) send(stream, now);
    if (first == nullptr || stream.next < first->next) first = &stream;
    next_due_ = std::min(next_due_, stream.next);
  }
  if (share_ < 1) send_on_slow_line(first, now);
}

void Telemetry::send(Stream& stream, base::RunTime now) {
  stream.send({core_, outbox_, now});
  stream.next += spacing(stream);
}

/// One packet, then none until the line has had the time for it beside the controls.
void Telemetry::send_on_slow_line(Stream* stream, base::RunTime now) {
  if (stream == nullptr || stream->next > now) return;
  send(*stream, now);
  next_due_ = now + base::from_seconds(stream->bytes / free_b_s_);
}

base::Duration Telemetry::spacing(const Stream& stream) const {
  if (share_ == 1 || stream.interval >= kKept) return stream.interval;
  return base::from_seconds(base::to_seconds(stream.interval) / share_);
}

/// How much of the usual rates the line carries beside the controls of the last second.
void Telemetry::share_line(base::RunTime now) {
  constexpr double kBitsPerByte = 10;
  constexpr double kTelemetry = 0.5;  // of what the controls leave
  const double line_b_s = core_.config.line.baud / kBitsPerByte;
  if (line_b_s <= 0) return;
  if (!measured_) {
    const std::uint32_t id = core_.hil.answer_by_motor ? mavlink::common::HilActuatorControls::kId
                                                       : mavlink::common::HilControls::kId;
    controls_b_s_ = core_.config.control_rate_hz * packet_bytes(id);
    control_bytes_then_ = control_bytes();
    measured_ = now;
  } else if (now - *measured_ >= std::chrono::seconds(1)) {
    const double sent = control_bytes();
    controls_b_s_ = (sent - control_bytes_then_) / base::to_seconds(now - *measured_);
    control_bytes_then_ = sent;
    measured_ = now;
  }
  double kept = 0;
  double usual = 0;
  for (const Stream& stream : streams_) {
    if (stream.interval <= base::Duration{}) continue;
    (stream.interval >= kKept ? kept : usual) += stream.bytes / base::to_seconds(stream.interval);
  }
  free_b_s_ = std::max(line_b_s - controls_b_s_, (kept + kLeastShare * usual) / kTelemetry);
  share_ = usual > 0 ? std::min((kTelemetry * free_b_s_ - kept) / usual, 1.0) : 1;
}

double Telemetry::control_bytes() const {
  double bytes = 0;
  for (const std::uint32_t id :
       {mavlink::common::HilControls::kId, mavlink::common::HilActuatorControls::kId}) {
    bytes += static_cast<double>(outbox_.counts()[id]) * packet_bytes(id);
  }
  return bytes;
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
