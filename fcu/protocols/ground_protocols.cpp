// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/ground_protocols.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/earth/deg_e7.hpp"
#include "base/earth/frames.hpp"
#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/services/timesync.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using mav::PacketView;
using namespace mavlink::common;  // NOLINT: a dispatcher over its messages

namespace {

/// Decodes and handles a packet of this message. @return whether it is one
template <class Message, class Handler>
bool take(const PacketView& packet, Handler&& handler) {
  if (packet.message_id != Message::kId) return false;
  if (const auto message = mav::decode<Message>(packet)) handler(*message);
  return true;
}

// Setpoints that companions stream, and sticks.

using Mask = PositionTargetTypemask;

/// Reads the parts that the mask does not ignore.
TrajectorySetpoint from_mask(Mask mask, const Vector3d& p, const Vector3d& v, const Vector3d& a,
                             double yaw, double yaw_rate) {
  constexpr Mask kPosition[] = {Mask::kXIgnore, Mask::kYIgnore, Mask::kZIgnore};
  constexpr Mask kVelocity[] = {Mask::kVxIgnore, Mask::kVyIgnore, Mask::kVzIgnore};
  constexpr Mask kAcceleration[] = {Mask::kAxIgnore, Mask::kAyIgnore, Mask::kAzIgnore};
  TrajectorySetpoint out;
  for (int i = 0; i < 3; ++i) {
    if (!has(mask, kPosition[i])) out.p_N[i] = p[i];
    if (!has(mask, kVelocity[i])) out.v_N[i] = v[i];
    if (!has(mask, kAcceleration[i])) out.a_N[i] = a[i];
  }
  if (!has(mask, Mask::kYawIgnore)) out.yaw_rad = yaw;
  if (!has(mask, Mask::kYawRateIgnore)) out.yaw_rate_rad_s = yaw_rate;
  return out;
}

double unit(std::int16_t value) { return std::clamp(value / 1000.0, -1.0, 1.0); }

/// Microseconds of a channel to -1..1; a value that is no pulse is the middle.
double channel(std::uint16_t pulse_us) {
  if (pulse_us < 800 || pulse_us > 2200) return 0;
  return std::clamp((pulse_us - 1500.0) / 500.0, -1.0, 1.0);
}

/// Channels 1 roll, 2 pitch (low is nose down), 3 throttle, 4 yaw: 1000..2000 us.
template <class Message>
Sticks from_channels(const Message& m) {
  return {.roll = channel(m.chan1_raw),
          .pitch = -channel(m.chan2_raw),
          .yaw = channel(m.chan4_raw),
          .throttle = 0.5 * (channel(m.chan3_raw) + 1)};
}

/// x forward, y right, r clockwise -1000..1000, z thrust 0..1000.
Sticks from_manual_control(const ManualControl& m) {
  return {.roll = unit(m.y),
          .pitch = unit(m.x),
          .yaw = unit(m.r),
          .throttle = std::clamp(m.z / 1000.0, 0.0, 1.0)};
}

/// Frames LOCAL_NED, LOCAL_OFFSET_NED (about the present place), BODY_NED and BODY_FRD (turned by
/// the present heading).
void on_position_target(const SetPositionTargetLocalNed& m, const EstimatorState& state,
                        OffboardTask& offboard, RunTime now) {
  TrajectorySetpoint setpoint =
      from_mask(m.type_mask, vec(m.x, m.y, m.z), vec(m.vx, m.vy, m.vz), vec(m.afx, m.afy, m.afz),
                static_cast<double>(m.yaw), static_cast<double>(m.yaw_rate));
  const bool body = m.coordinate_frame == MavFrame::kBodyNed ||
                    m.coordinate_frame == MavFrame::kBodyFrd ||
                    m.coordinate_frame == MavFrame::kBodyOffsetNed;
  const bool offset = body || m.coordinate_frame == MavFrame::kLocalOffsetNed;
  if (!offset && m.coordinate_frame != MavFrame::kLocalNed) return;
  if (body) {
    const double yaw = base::euler_rpy(state.q_ND).z();
    const Eigen::Rotation2Dd heading(yaw);
    setpoint.p_N.head<2>() = heading * Eigen::Vector2d(setpoint.p_N.head<2>());
    setpoint.v_N.head<2>() = heading * Eigen::Vector2d(setpoint.v_N.head<2>());
    setpoint.a_N.head<2>() = heading * Eigen::Vector2d(setpoint.a_N.head<2>());
    if (std::isfinite(setpoint.yaw_rad))
      setpoint.yaw_rad = base::wrap_angle(setpoint.yaw_rad + yaw);
  }
  if (offset) setpoint.p_N += state.p_N;
  offboard.on_trajectory(setpoint, now);
}

void on_global_target(const SetPositionTargetGlobalInt& m,
                      const std::optional<base::LocalProjection>& projection, double home_z,
                      OffboardTask& offboard, RunTime now) {
  if (!projection) return;
  const Vector3d there = projection->to_local(
      {base::degrees_of_e7(m.lat_int), base::degrees_of_e7(m.lon_int), projection->home().alt_m});
  const auto alt = static_cast<double>(m.alt);
  const bool relative = m.coordinate_frame == MavFrame::kGlobalRelativeAlt ||
                        m.coordinate_frame == MavFrame::kGlobalRelativeAltInt;
  const double z = relative ? home_z - alt : projection->home().alt_m - alt;
  offboard.on_trajectory(from_mask(m.type_mask, {there.x(), there.y(), z}, vec(m.vx, m.vy, m.vz),
                                   vec(m.afx, m.afy, m.afz), static_cast<double>(m.yaw),
                                   static_cast<double>(m.yaw_rate)),
                         now);
}

/// Attitude with thrust 0..1 of full scale.
/// @param full_n  the thrust of 1
void on_attitude_target(const SetAttitudeTarget& m, double full_n, OffboardTask& offboard,
                        RunTime now) {
  using A = AttitudeTargetTypemask;
  if (has(m.type_mask, A::kAttitudeIgnore) || has(m.type_mask, A::kThrottleIgnore)) return;
  AttitudeSetpoint setpoint;
  setpoint.q_ND = Eigen::Quaterniond(static_cast<double>(m.q[0]), static_cast<double>(m.q[1]),
                                     static_cast<double>(m.q[2]), static_cast<double>(m.q[3]));
  // One number that is none would stay in the integrators for good.
  if (!(setpoint.q_ND.norm() > 0.5) || !setpoint.q_ND.coeffs().allFinite()) return;
  if (!std::isfinite(m.thrust)) return;
  setpoint.q_ND.normalize();
  const double thrust = std::clamp(static_cast<double>(m.thrust), 0.0, 1.0);
  setpoint.thrust_n = thrust * full_n;
  if (!has(m.type_mask, A::kBodyYawRateIgnore) && std::isfinite(m.body_yaw_rate)) {
    setpoint.yaw_rate_rad_s = static_cast<double>(m.body_yaw_rate);
  }
  offboard.on_attitude(setpoint, now);
}

// Bulk data gets half of the bandwidth that the HIL stream leaves. Files go in bursts of pieces
// that delay a HIL packet by a millisecond at most, but are not so short that headers dominate.

constexpr double kFileHeaderBytes = 27;

/// Bytes per second. A line without a rate takes a packet each millisecond.
double bulk_rate(const LineConfig& line, double packet_bytes) {
  constexpr double kHilAndStreams_b_s = 28'000;
  if (line.baud <= 0) return 1000 * packet_bytes;
  return 0.5 * std::max(line.baud / 10 - kHilAndStreams_b_s, 2'000.0);
}

base::Duration param_interval(const LineConfig& line) {
  constexpr double kParamValueBytes = 40;
  return base::from_seconds(kParamValueBytes / bulk_rate(line, kParamValueBytes));
}

/// Size of a message on the line.
std::size_t packet_bytes(const FileTransferProtocol& message) {
  std::array<std::uint8_t, mav::kMaxPacketBytes> packet{};
  return mav::encode(message, {}, 0, packet);
}

mav::services::FtpServerLimits file_limits(const LineConfig& line) {
  constexpr double kLongest_s = 0.001;
  constexpr double kLeast = 32;
  const double most = mav::services::kFtpDataBytes;
  const double piece =
      line.baud <= 0 ? most
                     : std::clamp(line.baud / 10 * kLongest_s - kFileHeaderBytes, kLeast, most);
  return {.bytes_per_s = bulk_rate(line, piece + kFileHeaderBytes),
          .piece_bytes = static_cast<std::size_t>(piece)};
}

}  // namespace

GroundProtocols::GroundProtocols(View view)
    : view_(std::move(view)),
      telemetry_(view_.core, view_.outbox),
      params_(view_.target.params, view_.outbox, view_.texts,
              param_interval(view_.core.config.line)),
      commands_(view_.target, view_.outbox, view_.texts, telemetry_),
      missions_(view_.target.commander, view_.outbox, view_.texts),
      files_(view_.target.params),
      file_server_(
          // In MAVLink 2 as the telemetry, whatever was asked in: it leaves out zeros at the end.
          files_,
          [this](const auto& message) {
            view_.outbox.send(message);
            return packet_bytes(message);
          },
          file_limits(view_.core.config.line)) {}

void GroundProtocols::on_packet(const PacketView& packet, RunTime now) {
  if (on_link_packet(packet, now)) return;
  if (on_command_packet(packet, now)) return;
  if (on_param_packet(packet)) return;
  if (on_setpoint_packet(packet, now)) return;
  if (on_file_packet(packet, now)) return;
  on_mission_packet(packet, now);
}

bool GroundProtocols::on_link_packet(const PacketView& packet, RunTime now) {
  const auto reply = [&](const auto& answer) {
    if (answer) view_.outbox.reply(*answer, packet.version);
  };
  return take<Heartbeat>(packet,
                         [&](const auto& m) {
                           if (m.type == MavType::kGcs) view_.ground_station_heard = now;
                         }) ||
         take<Timesync>(packet,
                        [&](const auto& m) {
                          reply(mav::services::answer(m, packet.source, now - view_.core.start));
                        }) ||
         take<Ping>(packet, [&](const auto& m) { reply(mav::services::answer(m, packet.source)); });
}

bool GroundProtocols::on_command_packet(const PacketView& packet, RunTime now) {
  const mav::Source from = packet.source;
  const int version = packet.version;
  return take<CommandLong>(packet,
                           [&](const auto& m) { commands_.on_long(m, from, version, now); }) ||
         take<CommandInt>(packet,
                          [&](const auto& m) { commands_.on_int(m, from, version, now); }) ||
         take<SetMode>(packet,
                       [&](const auto& m) { commands_.on_set_mode(m, from, version, now); });
}

bool GroundProtocols::on_param_packet(const PacketView& packet) {
  const int version = packet.version;
  return take<ParamRequestList>(packet, [&](const auto&) { params_.on_list(version); }) ||
         take<ParamRequestRead>(packet, [&](const auto& m) { params_.on_read(m, version); }) ||
         take<ParamSet>(packet, [&](const auto& m) {
           params_.on_set(m, version);
           view_.apply_params();
         });
}

bool GroundProtocols::on_file_packet(const PacketView& packet, RunTime now) {
  return take<FileTransferProtocol>(
      packet, [&](const auto& m) { file_server_.on_request(m, packet.source, now); });
}

bool GroundProtocols::on_setpoint_packet(const PacketView& packet, RunTime now) {
  OffboardTask& offboard = view_.target.commander.offboard();
  const Estimator& estimator = view_.target.estimator;
  const auto on_radio = [&](const auto& m) { view_.pilot.radio = {from_channels(m), now}; };
  return take<SetPositionTargetLocalNed>(
             packet,
             [&](const auto& m) { on_position_target(m, estimator.state(), offboard, now); }) ||
         take<SetPositionTargetGlobalInt>(packet,
                                          [&](const auto& m) {
                                            on_global_target(m, estimator.projection(),
                                                             view_.target.home.p_N.z(), offboard,
                                                             now);
                                          }) ||
         take<SetAttitudeTarget>(packet,
                                 [&](const auto& m) {
                                   on_attitude_target(m, view_.core.config.vehicle.scales.u1_max_n,
                                                      offboard, now);
                                 }) ||
         take<ManualControl>(packet,
                             [&](const auto& m) {
                               if (m.target != 0 && m.target != view_.core.config.system_id) return;
                               view_.pilot.manual_control = {from_manual_control(m), now};
                             }) ||
         take<HilRcInputsRaw>(packet, on_radio) || take<RcChannelsOverride>(packet, on_radio);
}

bool GroundProtocols::on_mission_packet(const PacketView& packet, RunTime now) {
  const mav::Source from = packet.source;
  const int version = packet.version;
  const auto request = [&](const auto& m) {
    missions_.on_request(m.seq, m.mission_type, from, version, now);
  };
  return take<MissionCount>(packet,
                            [&](const auto& m) { missions_.on_count(m, from, version, now); }) ||
         take<MissionItemInt>(packet, [&](const auto& m) { missions_.on_item(m, from, now); }) ||
         take<MissionRequestList>(
             packet, [&](const auto& m) { missions_.on_request_list(m, from, version, now); }) ||
         take<MissionRequestInt>(packet, request) || take<MissionRequest>(packet, request) ||
         take<MissionAck>(packet, [&](const auto& m) { missions_.on_ack(m, from); }) ||
         take<MissionClearAll>(packet,
                               [&](const auto& m) { missions_.on_clear(m, from, version); }) ||
         take<MissionSetCurrent>(packet, [&](const auto& m) { missions_.on_set_current(m); });
}

/// A text that is longer than one message goes out in numbered pieces.
void GroundProtocols::send_texts() {
  for (const StatusTexts::Line& line : view_.texts.take()) {
    Statustext m;
    m.severity = line.severity;
    const std::size_t piece = m.text.size();
    const bool long_text = line.text.size() > piece;
    if (long_text) m.id = ++long_texts_ == 0 ? ++long_texts_ : long_texts_;  // 0 is a short one
    // A last piece that is exactly full is followed by an empty one: the NUL ends the text.
    for (std::size_t at = 0; at <= line.text.size(); at += piece) {
      mav::set_text(m.text, std::string_view(line.text).substr(at, piece));
      view_.outbox.send(m);
      ++m.chunk_seq;
      if (!long_text) break;
    }
  }
}

void GroundProtocols::hurry_after_a_change() {
  const Commander& commander = view_.target.commander;
  const bool changed = commander.armed() != was_armed_ || commander.mode() != was_mode_ ||
                       commander.landed() != was_landed_;
  if (!changed) return;
  was_armed_ = commander.armed();
  was_mode_ = commander.mode();
  was_landed_ = commander.landed();
  telemetry_.hurry();
}

void GroundProtocols::update(RunTime now) {
  hurry_after_a_change();
  view_.apply_params();
  if (!view_.texts.empty()) send_texts();
  telemetry_.update(now);
  commands_.update(now);
  params_.update(now);
  missions_.update(now);
  file_server_.update(now);
}

}  // namespace cas::fcu
