// SPDX-License-Identifier: BSD-3-Clause
#include "tests/casd/fake_vehicle.hpp"

#include <algorithm>

#include "casd/station/services.hpp"

namespace cas::casd::test {

using namespace mavlink::common;

void FakeVehicle::handle(const mav::PacketView& packet, base::RunTime now) {
  if (packet.message_id == Heartbeat::kId) ++heartbeats;
  if (const auto moved = mav::decode<ManualControl>(packet)) sticks.push_back(*moved);
  if (const auto command = mav::decode<CommandLong>(packet)) {
    if (command->target_system != source_.system) return;
    commands.push_back(*command);
    fall_silent(command->command);
    if (deaf()) return;
    take_mode(*command);
    answer(command->command, now);
    if (script.beats_on_request && command->command == MavCmd::kRequestMessage &&
        command->param1 == static_cast<float>(Heartbeat::kId)) {
      say_heartbeat(now + script.delay);
    }
  } else if (const auto placed = mav::decode<CommandInt>(packet)) {
    int_commands.push_back(*placed);
    fall_silent(placed->command);
    if (!deaf()) answer(placed->command, now);
  } else if (const auto set = mav::decode<ParamSet>(packet)) {
    param_sets.push_back(*set);
    if (!deaf()) on_param_set(*set, now);
  } else if (const auto read = mav::decode<ParamRequestRead>(packet)) {
    ++param_reads;
    if (deaf()) return;
    std::string name(mav::text(read->param_id));
    if (read->param_index >= 0) {
      name = std::next(params.begin(), read->param_index)->first;
      say_param(name, now + script.delay, static_cast<std::uint16_t>(read->param_index));
    } else if (params.contains(name)) {
      say_param(name, now + script.delay);
    }
  } else if (packet.message_id == ParamRequestList::kId) {
    on_param_list(now);
  }
}

bool FakeVehicle::deaf() { return script.deaf_for > 0 && script.deaf_for-- > 0; }

void FakeVehicle::take_mode(const CommandLong& command) {
  const bool takes = script.result == MavResult::kAccepted && !script.keeps_mode;
  if (command.command != MavCmd::kDoSetMode || !takes) return;
  const auto main = static_cast<std::uint32_t>(command.param2);
  const auto sub = static_cast<std::uint32_t>(command.param3);
  custom_mode = autopilot == MavAutopilot::kPx4 ? main << 16 | sub << 24 : main;
}

/// Drops queued messages, too.
void FakeVehicle::fall_silent(MavCmd command) {
  if (command != script.silent_from) return;
  silent_ = true;
  out_.clear();
}

void FakeVehicle::answer(MavCmd command, base::RunTime now) {
  CommandAck ack{.command = command, .target_system = 254, .target_component = 190};
  if (script.in_progress_first) {
    ack.result = MavResult::kInProgress;
    say(ack, now);
  }
  ack.result = script.result;
  for (int i = 0; i < script.answers; ++i) say(ack, now + script.delay);
  if (script.then) {
    ack.result = *script.then;
    say(ack, now + script.delay);
  }
  if (!script.text.empty()) say_text(script.text, now + script.delay);
}

void FakeVehicle::on_param_set(const ParamSet& message, base::RunTime now) {
  const std::string name(mav::text(message.param_id));
  const auto found = params.find(name);
  if (found == params.end()) return;
  const auto encoding =
      autopilot == MavAutopilot::kArdupilotmega ? ParamEncoding::kCast : ParamEncoding::kBytewise;
  found->second.value =
      std::min(from_wire(encoding, message.param_type, message.param_value), found->second.high);
  say_param(name, now + script.delay);
}

void FakeVehicle::on_param_list(base::RunTime now) {
  std::uint16_t index = 0;
  for (const auto& [name, param] : params) {
    const bool lost = std::count(lost_in_list.begin(), lost_in_list.end(), name) > 0;
    if (!lost) say_param(name, now + script.delay, index);
    ++index;
  }
  lost_in_list.clear();
}

void FakeVehicle::say_param(const std::string& name, base::RunTime at, std::uint16_t index) {
  if (name == unsaid) return;
  const Param& param = params.at(name);
  const auto encoding =
      autopilot == MavAutopilot::kArdupilotmega ? ParamEncoding::kCast : ParamEncoding::kBytewise;
  ParamValue message;
  mav::set_text(message.param_id, name);
  message.param_type = param.type;
  // A vehicle may have a value that casd would not write: NaN.
  message.param_value =
      to_wire(encoding, param.type, param.value).value_or(static_cast<float>(param.value));
  message.param_count = static_cast<std::uint16_t>(params.size());
  message.param_index = index;
  say(message, at);
}

void FakeVehicle::say_heartbeat(base::RunTime at) {
  if (silent_) return;
  Heartbeat message{.type = type,
                    .autopilot = autopilot,
                    .base_mode = base_mode,
                    .custom_mode = custom_mode,
                    .mavlink_version = 3};
  say(message, at);
}

void FakeVehicle::say_text(const std::string& text, base::RunTime at) {
  Statustext message{.severity = MavSeverity::kCritical};
  mav::set_text(message.text, text);
  say(message, at);
}

std::optional<mav::PacketBuffer> FakeVehicle::take(base::RunTime now) {
  const auto due =
      std::find_if(out_.begin(), out_.end(), [now](const Outgoing& out) { return out.at <= now; });
  if (due == out_.end()) return std::nullopt;
  const mav::PacketBuffer packet = due->packet;
  out_.erase(due);
  return packet;
}

}  // namespace cas::casd::test
