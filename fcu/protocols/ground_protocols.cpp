// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/ground_protocols.hpp"

#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/setpoint_messages.hpp"
#include "mavlink/common/mission_request.hpp"
#include "mavlink/common/mission_request_int.hpp"
#include "mavlink/common/statustext.hpp"

namespace cas::fcu {

using base::RunTime;
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
  if (m.tc1 != 0) return;  // an answer; we ask nobody
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
