// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/intervention.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/command.hpp"
#include "mavlink_gen/services/failure_order.hpp"

namespace cas::casd {

using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

/// Messages that fly a vehicle. Commands are judged one by one.
constexpr std::array kSteering{SetMode::kId,
                               ManualControl::kId,
                               RcChannelsOverride::kId,
                               SetAttitudeTarget::kId,
                               SetPositionTargetLocalNed::kId,
                               SetPositionTargetGlobalInt::kId,
                               MissionCount::kId,
                               MissionClearAll::kId,
                               MissionSetCurrent::kId};

bool is_steering(std::uint32_t message_id) {
  return std::ranges::find(kSteering, message_id) != kSteering.end();
}

std::string number_of(MavCmd command) {
  return "command " + std::to_string(static_cast<unsigned>(command));
}

std::string with_word(MavCmd command, std::string_view word) {
  return number_of(command) + " (" + std::string(word) + ")";
}

std::string command_words(MavCmd command) {
  constexpr std::array<std::pair<MavCmd, std::string_view>, 7> kWords{
      {{MavCmd::kComponentArmDisarm, "arm or disarm"},
       {MavCmd::kDoFlighttermination, "end the flight"},
       {MavCmd::kNavTakeoff, "takeoff"},
       {MavCmd::kNavLand, "land"},
       {MavCmd::kNavReturnToLaunch, "return to launch"},
       {MavCmd::kDoSetMode, "another mode"},
       {MavCmd::kDoReposition, "go to a place"}}};
  const auto found = std::ranges::find(kWords, command, &decltype(kWords)::value_type::first);
  return found == kWords.end() ? number_of(command) : with_word(command, found->second);
}

/// @param command  COMMAND_LONG or COMMAND_INT
template <class Command>
std::optional<Act> act_of_command(const Command& command) {
  if (only_asks(command.command)) return std::nullopt;
  const bool disarms =
      mav::services::stops({.id = command.command, .params = {command.param1, command.param2}});
  Act act{.what = command_words(command.command),
          .target = {command.target_system, command.target_component},
          .disarms = disarms};
  const bool arms = command.command == MavCmd::kComponentArmDisarm;
  if (arms || (disarms && command.command != MavCmd::kDoFlighttermination)) {
    act.what = with_word(command.command, disarms ? "disarm" : "arm");
  }
  return act;
}

/// Whether one of the commands with a time ([ASLUAV]), which casd does not read, is of this number.
bool is_stamped(const mav::PacketView& packet, MavCmd command) {
  constexpr std::uint32_t kCommandIntStamped = 223;
  constexpr std::uint32_t kCommandLongStamped = 224;
  constexpr std::size_t kCommandAt = 40;  // of both
  const std::uint32_t id = packet.message_id;
  if (id != kCommandIntStamped && id != kCommandLongStamped) return false;
  if (packet.payload.size() < kCommandAt + 2) return false;
  return packet.payload[kCommandAt] + 256U * packet.payload[kCommandAt + 1] ==
         static_cast<unsigned>(command);
}

/// Whether a parameter says when the autopilot disarms itself on the ground.
bool is_of_disarming(std::string_view parameter) {
  return parameter == "DISARM_DELAY" || parameter == "COM_DISARM_PRFLT";
}

}  // namespace

bool only_asks(MavCmd command) {
  using enum MavCmd;
  constexpr std::array kQuestions{
      kGetHomePosition, kGetMessageInterval,     kSetMessageInterval,          kRequestMessage,
      kRunPrearmChecks, kRequestProtocolVersion, kRequestAutopilotCapabilities};
  return std::ranges::find(kQuestions, command) != kQuestions.end();
}

bool is_failure(const mav::PacketView& packet) {
  return mav::services::failure_command(packet).has_value() ||
         is_stamped(packet, MavCmd::kInjectFailure);
}

std::optional<Act> act_of(const mav::PacketView& packet) {
  if (const auto failure = mav::services::failure_command(packet)) {
    const std::string words = failure->order ? to_words(*failure->order) : "none";
    return Act{.what = with_word(MavCmd::kInjectFailure, "failure " + words),
               .target = failure->target};
  }
  if (const auto command = mav::decode<CommandLong>(packet)) return act_of_command(*command);
  if (const auto placed = mav::decode<CommandInt>(packet)) return act_of_command(*placed);
  if (const auto set = mav::decode<ParamSet>(packet)) {
    const std::string_view parameter = mav::text(set->param_id);
    if (!is_of_disarming(parameter)) return std::nullopt;
    return Act{.what = "PARAM_SET " + std::string(parameter),
               .target = {set->target_system, set->target_component}};
  }
  if (!is_steering(packet.message_id)) return std::nullopt;
  const mav::MessageInfo& known = *table().find(packet.message_id);
  Act act{.what = std::string(known.name), .target = mav::target_of(packet, known)};
  if (const auto sticks = mav::decode<ManualControl>(packet)) act.target.system = sticks->target;
  return act;
}

std::optional<Act> act_of(const CommandAck& answer) {
  const bool of_arming = answer.command == MavCmd::kComponentArmDisarm;
  if (!of_arming && answer.command != MavCmd::kDoFlighttermination) return std::nullopt;
  return Act{.what = command_words(answer.command) + ", by the vehicle's answer to it",
             .target = {},
             .disarms = of_arming || answer.result == MavResult::kAccepted};
}

bool may_be_act(std::uint32_t message_id) {
  return message_id == CommandLong::kId || message_id == CommandInt::kId ||
         message_id == CommandAck::kId || message_id == ParamSet::kId || is_steering(message_id);
}

void Interventions::add(Intervention intervention) {
  for (Intervention& known : all_) {
    if (known.by != intervention.by || known.link != intervention.link ||
        known.act.what != intervention.act.what) {
      continue;
    }
    known.times += intervention.times;
    known.at = intervention.at;
    known.act.disarms = known.act.disarms || intervention.act.disarms;
    return;
  }
  all_.push_back(std::move(intervention));
  if (all_.size() <= kMost) return;
  const auto idle =
      std::ranges::find_if(all_, [](const Intervention& i) { return !i.act.disarms; });
  all_.erase(idle == all_.end() ? all_.begin() : idle);
}

}  // namespace cas::casd
