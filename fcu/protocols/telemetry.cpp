// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry.hpp"

#include <algorithm>
#include <cmath>

#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/telemetry_messages.hpp"
#include "mavlink/common/altitude.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/attitude_quaternion.hpp"
#include "mavlink/common/attitude_target.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/available_modes.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/current_mode.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/global_position_int.hpp"
#include "mavlink/common/gps_global_origin.hpp"
#include "mavlink/common/gps_raw_int.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/mission_current.hpp"
#include "mavlink/common/position_target_local_ned.hpp"
#include "mavlink/common/protocol_version.hpp"
#include "mavlink/common/scaled_pressure.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/system_time.hpp"
#include "mavlink/common/vfr_hud.hpp"
#include "mavlink/common/vibration.hpp"

namespace cas::fcu {

using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

/// One message that the controller can send about itself.
struct MessageSource {
  std::uint32_t id = 0;
  double rate_hz = 0;  ///< usual rate; 0: on request only
  void (*send)(FcuCore& core, base::RunTime now, int version) = nullptr;
};

constexpr MessageSource kSources[] = {
    {Heartbeat::kId, 1, send_heartbeat},
    {SysStatus::kId, 1, send_sys_status},
    {Attitude::kId, 50, send_attitude},
    {AttitudeQuaternion::kId, 10, send_attitude_quaternion},
    {AttitudeTarget::kId, 2, send_attitude_target},
    {LocalPositionNed::kId, 30, send_local_position},
    {PositionTargetLocalNed::kId, 10, send_position_target},
    {GlobalPositionInt::kId, 5, send_global_position},
    {GpsRawInt::kId, 2, send_gps_raw},
    {VfrHud::kId, 4, send_vfr_hud},
    {mavlink::common::Altitude::kId, 1, send_altitude},
    {Vibration::kId, 0.5, send_vibration},
    {EstimatorStatus::kId, 1, send_estimator_status},
    {ExtendedSysState::kId, 1, send_extended_sys_state},
    {BatteryStatus::kId, 0.5, send_battery_status},
    {HomePosition::kId, 0.5, send_home_position},
    {GpsGlobalOrigin::kId, 0, send_gps_global_origin},
    {ServoOutputRaw::kId, 2, send_servo_output_raw},
    {ScaledPressure::kId, 0, send_scaled_pressure},
    {SystemTime::kId, 1, send_system_time},
    {MissionCurrent::kId, 1, send_mission_current},
    {AutopilotVersion::kId, 0, send_autopilot_version},
    {ProtocolVersion::kId, 0, send_protocol_version},
    {AvailableModes::kId, 0, send_available_modes},
    {CurrentMode::kId, 0.5, send_current_mode},
};

/// Sent at once when arming state, mode or landed state change.
constexpr std::uint32_t kHurriedIds[] = {Heartbeat::kId, ExtendedSysState::kId};

/// First update: streams start spread over their intervals instead of all at once.
constexpr base::Duration kSpread = std::chrono::microseconds(1700);
constexpr base::Duration kShortestInterval = std::chrono::milliseconds(2);
constexpr double kLongestInterval_us = 1e9;

}  // namespace

Telemetry::Telemetry() {
  base::Duration offset{};
  for (const MessageSource& source : kSources) {
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

void Telemetry::update(FcuCore& core, base::RunTime now) {
  if (hurry_) {
    hurry_ = false;
    for (const std::uint32_t id : kHurriedIds) send_now(id, core, now, 2);
  }
  if (now < next_due_) return;
  next_due_ = now + std::chrono::seconds(1);
  for (Stream& stream : streams_) {
    if (stream.interval <= base::Duration{}) continue;
    if (stream.next < now - stream.interval) stream.next = now;  // never catch up in a burst
    if (stream.next <= now) {
      stream.send(core, now, 2);
      stream.next += stream.interval;
    }
    next_due_ = std::min(next_due_, stream.next);
  }
}

Telemetry::Sent Telemetry::send_now(std::uint32_t id, FcuCore& core, base::RunTime now,
                                    int version) {
  Stream* stream = find(id);
  if (stream == nullptr) return Sent::kUnknown;
  const std::uint64_t before = core.outbox.counts()[id];
  stream->send(core, now, version);
  return core.outbox.counts()[id] > before ? Sent::kSent : Sent::kNothingYet;
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
