// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/command_handler.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "base/earth/deg_e7.hpp"
#include "fcu/protocols/flight_commands.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/message_interval.hpp"
#include "mavlink/common/protocol_version.hpp"

namespace cas::fcu {

using base::RunTime;
using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

constexpr std::uint32_t kHighestMessageId = 0xFFFFFF;
constexpr double kRepetition_s = 5;  ///< a later one with the same words is a new wish

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace

CommandHandler::CommandHandler(const CommandTarget& target, Outbox& outbox, StatusTexts& texts,
                               Telemetry& telemetry)
    : target_(target),
      outbox_(outbox),
      texts_(texts),
      telemetry_(telemetry),
      calibration_({.commander = target.commander,
                    .estimator = target.estimator,
                    .texts = texts,
                    .restart_estimate = target.restart_estimate}) {}

void CommandHandler::acknowledge(const Command& command, Result result, int percent) {
  CommandAck ack;
  ack.command = command.id;
  ack.result = result;
  ack.progress = static_cast<std::uint8_t>(percent);
  ack.target_system = command.from.system;
  ack.target_component = command.from.component;
  outbox_.reply(ack, command.version);
}

bool CommandHandler::was_answered(const Command& command, RunTime now) const {
  return last_ && last_->command.id == command.id && last_->command.from == command.from &&
         std::equal(command.param.begin(), command.param.end(), last_->command.param.begin(),
                    same) &&
         last_->result != MavResult::kTemporarilyRejected &&
         base::to_seconds(now - last_->at) < kRepetition_s;
}

void CommandHandler::run(const Command& command, bool repeated, RunTime now) {
  if (repeated && was_answered(command, now)) return acknowledge(command, last_->result);
  const MavResult result = execute(command, now);
  last_ = Answered{command, result, now};
  acknowledge(command, result);
}

void CommandHandler::on_long(const CommandLong& m, mav::Source from, int version, RunTime now) {
  Command command;
  command.id = m.command;
  const float values[] = {m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7};
  for (std::size_t i = 0; i < 7; ++i) command.param[i] = static_cast<double>(values[i]);
  // A float resolves latitude and longitude to a metre; senders leave unset ones 0, 0.
  if (command.param[4] == 0 && command.param[5] == 0) command.param[4] = command.param[5] = kUnset;
  command.from = from;
  command.version = version;
  run(command, m.confirmation > 0, now);
}

void CommandHandler::on_int(const CommandInt& m, mav::Source from, int version, RunTime now) {
  constexpr std::int32_t kNoPlace = std::numeric_limits<std::int32_t>::max();
  Command command;
  command.id = m.command;
  const float values[] = {m.param1, m.param2, m.param3, m.param4};
  for (std::size_t i = 0; i < 4; ++i) command.param[i] = static_cast<double>(values[i]);
  const double unit = m.frame == MavFrame::kLocalNed ? 1e-4 : 1 / base::kDegE7;
  command.param[4] = m.x == kNoPlace ? kUnset : m.x * unit;
  command.param[5] = m.y == kNoPlace ? kUnset : m.y * unit;
  if (m.x == 0 && m.y == 0 && m.frame != MavFrame::kLocalNed) {
    command.param[4] = command.param[5] = kUnset;
  }
  command.param[6] = static_cast<double>(m.z);
  command.frame = m.frame;
  command.from = from;
  command.version = version;
  run(command, false, now);
}

void CommandHandler::on_set_mode(const SetMode& m, mav::Source from, int version, RunTime now) {
  Command command;
  command.id = MavCmd::kDoSetMode;
  command.from = from;
  command.version = version;
  const MavResult result =
      has(static_cast<MavModeFlag>(m.base_mode), MavModeFlag::kCustomModeEnabled)
          ? set_flight_mode(flight_mode_from_custom(m.custom_mode), target_, now)
          : MavResult::kUnsupported;
  acknowledge(command, result);
}

void CommandHandler::update(RunTime now) {
  if (const auto told = calibration_.update(now)) {
    acknowledge(told->command, told->result, told->percent);
    last_.reset();  // the stored answer is out of date
  }
}

MavResult CommandHandler::execute(const Command& command, RunTime now) {
  const MavResult result = flight_command(command, target_, now);
  if (result != MavResult::kUnsupported) {
    telemetry_.hurry();
    return result;
  }
  return information_command(command, now);
}

MavResult CommandHandler::request_message(const Command& command, RunTime now) {
  const std::uint32_t id = whole_number(command.param[0], kHighestMessageId);
  switch (telemetry_.send_now(id, now, command.version)) {
    case Telemetry::Sent::kSent:
      return MavResult::kAccepted;
    case Telemetry::Sent::kNothingYet:
      return MavResult::kTemporarilyRejected;
    case Telemetry::Sent::kUnknown:
      return MavResult::kUnsupported;
  }
  return MavResult::kFailed;
}

MavResult CommandHandler::information_command(const Command& command, RunTime now) {
  const std::uint32_t id = whole_number(command.param[0], kHighestMessageId);
  switch (command.id) {
    case MavCmd::kRequestMessage:
      return request_message(command, now);
    case MavCmd::kSetMessageInterval:
      return telemetry_.set_interval(id, command.param[1]) ? MavResult::kAccepted
                                                           : MavResult::kUnsupported;
    case MavCmd::kGetMessageInterval:
      outbox_.reply(MessageInterval{static_cast<std::uint16_t>(id), telemetry_.interval_us(id)},
                    command.version);
      return MavResult::kAccepted;
    case MavCmd::kRequestAutopilotCapabilities:
      telemetry_.send_now(AutopilotVersion::kId, now, command.version);
      return MavResult::kAccepted;
    case MavCmd::kRequestProtocolVersion:
      telemetry_.send_now(ProtocolVersion::kId, now, 2);
      return MavResult::kAccepted;
    case MavCmd::kGetHomePosition:
      telemetry_.send_now(HomePosition::kId, now, command.version);
      return target_.home.set ? MavResult::kAccepted : MavResult::kTemporarilyRejected;
    case MavCmd::kRunPrearmChecks:
      if (const auto reason = reason_not_to_arm(target_.arming_input(now))) {
        texts_.critical("Preflight Fail: " + *reason);
      } else {
        texts_.info("Preflight checks passed");
      }
      return MavResult::kAccepted;
    case MavCmd::kPreflightCalibration:
      return calibration_.on_command(command, now);
    case MavCmd::kPreflightStorage:
      // Parameters are saved as they change; 2 resets them.
      if (target_.commander.armed()) return MavResult::kTemporarilyRejected;
      if (command.param[0] == 2) target_.params.reset_to_defaults();
      return MavResult::kAccepted;
    default:
      return MavResult::kUnsupported;
  }
}

}  // namespace cas::fcu
