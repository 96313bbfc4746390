// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/ground_protocols.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/core/fcu_core.hpp"
#include "mavlink/common/hil_rc_inputs_raw.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/mission_request.hpp"
#include "mavlink/common/mission_request_int.hpp"
#include "mavlink/common/rc_channels_override.hpp"
#include "mavlink/common/set_attitude_target.hpp"
#include "mavlink/common/set_position_target_global_int.hpp"
#include "mavlink/common/set_position_target_local_ned.hpp"
#include "mavlink/common/statustext.hpp"

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

void on_heartbeat(const Heartbeat& m, FcuCore& core, RunTime now) {
  if (m.type != MavType::kGcs) return;
  core.ground_station_seen = true;
  core.ground_station_last = now;
}

void on_timesync(const Timesync& m, const PacketView& packet, FcuCore& core, RunTime now) {
  if (m.tc1 != 0) return;  // an answer, and we never ask
  Timesync answer;
  answer.tc1 = (now - core.start).count();
  answer.ts1 = m.ts1;
  answer.target_system = packet.source.system;
  answer.target_component = packet.source.component;
  core.outbox.reply(answer, packet.version);
}

void on_ping(const Ping& m, const PacketView& packet, FcuCore& core) {
  if (m.target_system != 0 || m.target_component != 0) return;  // an answer
  core.outbox.reply(Ping{m.time_usec, m.seq, packet.source.system, packet.source.component},
                    packet.version);
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

Vector3d vec(float x, float y, float z) {
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

double unit(std::int16_t value) { return std::clamp(value / 1000.0, -1.0, 1.0); }

/// Microseconds of a channel to -1..1; a value that is no pulse is the middle.
double channel(std::uint16_t pulse_us) {
  if (pulse_us < 800 || pulse_us > 2200) return 0;
  return std::clamp((pulse_us - 1500.0) / 500.0, -1.0, 1.0);
}

void take_channels(std::uint16_t roll, std::uint16_t pitch, std::uint16_t throttle,
                   std::uint16_t yaw, ManualInput& input, RunTime now) {
  input.sticks.roll = channel(roll);
  input.sticks.pitch = -channel(pitch);
  input.sticks.throttle = 0.5 * (channel(throttle) + 1);
  input.sticks.yaw = channel(yaw);
  input.last = now;
  input.seen = true;
}

/// Frames LOCAL_NED, LOCAL_OFFSET_NED (about the present place), BODY_NED and BODY_FRD (turned by
/// the present heading).
void on_position_target(const SetPositionTargetLocalNed& m, FcuCore& core, RunTime now) {
  TrajectorySetpoint setpoint =
      from_mask(m.type_mask, vec(m.x, m.y, m.z), vec(m.vx, m.vy, m.vz), vec(m.afx, m.afy, m.afz),
                static_cast<double>(m.yaw), static_cast<double>(m.yaw_rate));
  const EstimatorState& state = core.estimator.state();
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
  core.commander.offboard().on_trajectory(setpoint, now);
}

void on_global_target(const SetPositionTargetGlobalInt& m, FcuCore& core, RunTime now) {
  const auto& projection = core.estimator.projection();
  if (!projection) return;
  const Vector3d there =
      projection->to_local({m.lat_int * 1e-7, m.lon_int * 1e-7, projection->home().alt_m});
  const auto alt = static_cast<double>(m.alt);
  const bool relative = m.coordinate_frame == MavFrame::kGlobalRelativeAlt ||
                        m.coordinate_frame == MavFrame::kGlobalRelativeAltInt;
  const double z = relative ? core.home_N.z() - alt : projection->home().alt_m - alt;
  core.commander.offboard().on_trajectory(
      from_mask(m.type_mask, {there.x(), there.y(), z}, vec(m.vx, m.vy, m.vz),
                vec(m.afx, m.afy, m.afz), static_cast<double>(m.yaw),
                static_cast<double>(m.yaw_rate)),
      now);
}

/// Attitude with thrust 0..1 of full scale.
void on_attitude_target(const SetAttitudeTarget& m, FcuCore& core, RunTime now) {
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
  setpoint.thrust_n = thrust * core.config.vehicle.scales.u1_max_n;
  if (!has(m.type_mask, A::kBodyYawRateIgnore) && std::isfinite(m.body_yaw_rate)) {
    setpoint.yaw_rate_rad_s = static_cast<double>(m.body_yaw_rate);
  }
  core.commander.offboard().on_attitude(setpoint, now);
}

/// x forward, y right, r clockwise -1000..1000, z thrust 0..1000.
void on_manual_control(const ManualControl& m, FcuCore& core, RunTime now) {
  if (m.target != 0 && m.target != core.config.system_id) return;
  ManualInput& input = core.manual_control;
  input.sticks.pitch = unit(m.x);
  input.sticks.roll = unit(m.y);
  input.sticks.yaw = unit(m.r);
  input.sticks.throttle = std::clamp(m.z / 1000.0, 0.0, 1.0);
  input.last = now;
  input.seen = true;
}

/// Channels 1 roll, 2 pitch (low is nose down), 3 throttle, 4 yaw: 1000..2000 us.
void on_rc_inputs(const HilRcInputsRaw& m, FcuCore& core, RunTime now) {
  take_channels(m.chan1_raw, m.chan2_raw, m.chan3_raw, m.chan4_raw, core.rc_input, now);
}

void on_rc_override(const RcChannelsOverride& m, FcuCore& core, RunTime now) {
  take_channels(m.chan1_raw, m.chan2_raw, m.chan3_raw, m.chan4_raw, core.rc_input, now);
}

}  // namespace

void GroundProtocols::on_packet(const PacketView& packet, FcuCore& core, RunTime now) {
  if (on_link_packet(packet, core, now)) return;
  if (on_command_packet(packet, core, now)) return;
  if (on_param_packet(packet, core)) return;
  if (on_setpoint_packet(packet, core, now)) return;
  on_mission_packet(packet, core, now);
}

bool GroundProtocols::on_link_packet(const PacketView& packet, FcuCore& core, RunTime now) {
  return take<Heartbeat>(packet, [&](const auto& m) { on_heartbeat(m, core, now); }) ||
         take<Timesync>(packet, [&](const auto& m) { on_timesync(m, packet, core, now); }) ||
         take<Ping>(packet, [&](const auto& m) { on_ping(m, packet, core); });
}

bool GroundProtocols::on_command_packet(const PacketView& packet, FcuCore& core, RunTime now) {
  const mav::Source from = packet.source;
  const int version = packet.version;
  return take<CommandLong>(
             packet, [&](const auto& m) { commands_.on_long(m, from, version, core, now); }) ||
         take<CommandInt>(packet,
                          [&](const auto& m) { commands_.on_int(m, from, version, core, now); }) ||
         take<SetMode>(packet,
                       [&](const auto& m) { commands_.on_set_mode(m, from, version, core, now); });
}

bool GroundProtocols::on_param_packet(const PacketView& packet, FcuCore& core) {
  const int version = packet.version;
  return take<ParamRequestList>(packet, [&](const auto&) { params_.on_list(version); }) ||
         take<ParamRequestRead>(packet,
                                [&](const auto& m) { params_.on_read(m, core, version); }) ||
         take<ParamSet>(packet, [&](const auto& m) {
           params_.on_set(m, core, version);
           core.apply_params();
         });
}

bool GroundProtocols::on_setpoint_packet(const PacketView& packet, FcuCore& core, RunTime now) {
  const auto to = [&](auto handler) {
    return [&, handler](const auto& m) { handler(m, core, now); };
  };
  return take<SetPositionTargetLocalNed>(packet, to(on_position_target)) ||
         take<SetPositionTargetGlobalInt>(packet, to(on_global_target)) ||
         take<SetAttitudeTarget>(packet, to(on_attitude_target)) ||
         take<ManualControl>(packet, to(on_manual_control)) ||
         take<HilRcInputsRaw>(packet, to(on_rc_inputs)) ||
         take<RcChannelsOverride>(packet, to(on_rc_override));
}

bool GroundProtocols::on_mission_packet(const PacketView& packet, FcuCore& core, RunTime now) {
  const mav::Source from = packet.source;
  const int version = packet.version;
  const auto request = [&](const auto& m) {
    missions_.on_request(m.seq, m.mission_type, from, version, core);
  };
  return take<MissionCount>(
             packet, [&](const auto& m) { missions_.on_count(m, from, version, core, now); }) ||
         take<MissionItemInt>(
             packet, [&](const auto& m) { missions_.on_item(m, from, version, core, now); }) ||
         take<MissionRequestList>(
             packet, [&](const auto& m) { missions_.on_request_list(m, from, version, core); }) ||
         take<MissionRequestInt>(packet, request) || take<MissionRequest>(packet, request) ||
         take<MissionClearAll>(
             packet, [&](const auto& m) { missions_.on_clear(m, from, version, core); }) ||
         take<MissionSetCurrent>(packet,
                                 [&](const auto& m) { missions_.on_set_current(m, core, now); });
}

/// A text that is longer than one message goes out in numbered pieces.
void GroundProtocols::send_texts(FcuCore& core) {
  for (const StatusTexts::Line& line : core.texts.take()) {
    Statustext m;
    m.severity = line.severity;
    const std::size_t piece = m.text.size();
    const bool long_text = line.text.size() > piece;
    if (long_text) m.id = ++long_texts_ == 0 ? ++long_texts_ : long_texts_;  // 0 is a short one
    // A last piece that is exactly full is followed by an empty one: the NUL ends the text.
    for (std::size_t at = 0; at <= line.text.size(); at += piece) {
      mav::set_text(m.text, std::string_view(line.text).substr(at, piece));
      core.outbox.send(m);
      ++m.chunk_seq;
      if (!long_text) break;
    }
  }
}

void GroundProtocols::hurry_after_a_change(const FcuCore& core) {
  const Commander& commander = core.commander;
  const bool changed = commander.armed() != was_armed_ || commander.mode() != was_mode_ ||
                       commander.landed() != was_landed_;
  if (!changed) return;
  was_armed_ = commander.armed();
  was_mode_ = commander.mode();
  was_landed_ = commander.landed();
  telemetry_.hurry();
}

void GroundProtocols::update(FcuCore& core, RunTime now) {
  hurry_after_a_change(core);
  core.apply_params();
  if (!core.texts.empty()) send_texts(core);
  telemetry_.update(core, now);
  commands_.update(core, now);
  params_.update(core, now);
  missions_.update(core, now);
}

}  // namespace cas::fcu
