// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/failure_order.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "mavlink/common/command_int.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::mav::services {
namespace {

using mavlink::common::CommandInt;
using mavlink::common::CommandLong;
using mavlink::common::MavCmd;

// The words of PX4's systemcmds/failure.
constexpr std::array<std::pair<FailureUnit, std::string_view>, 15> kUnits{
    {{FailureUnit::kGyro, "gyro"},
     {FailureUnit::kAccel, "accel"},
     {FailureUnit::kMag, "mag"},
     {FailureUnit::kBaro, "baro"},
     {FailureUnit::kGps, "gps"},
     {FailureUnit::kOpticalFlow, "optical_flow"},
     {FailureUnit::kVio, "vio"},
     {FailureUnit::kDistanceSensor, "distance_sensor"},
     {FailureUnit::kAirspeed, "airspeed"},
     {FailureUnit::kBattery, "battery"},
     {FailureUnit::kMotor, "motor"},
     {FailureUnit::kServo, "servo"},
     {FailureUnit::kAvoidance, "avoidance"},
     {FailureUnit::kRcSignal, "rc_signal"},
     {FailureUnit::kMavlinkSignal, "mavlink_signal"}}};
constexpr std::array<std::pair<FailureType, std::string_view>, 8> kTypes{
    {{FailureType::kOk, "ok"},
     {FailureType::kOff, "off"},
     {FailureType::kStuck, "stuck"},
     {FailureType::kGarbage, "garbage"},
     {FailureType::kWrong, "wrong"},
     {FailureType::kSlow, "slow"},
     {FailureType::kDelayed, "delayed"},
     {FailureType::kIntermittent, "intermittent"}}};

template <class Words, class Key>
std::string word_of(const Words& words, Key key) {
  const auto found = std::ranges::find(words, key, &Words::value_type::first);
  if (found == words.end()) return "number " + std::to_string(static_cast<int>(key));
  return std::string(found->second);
}

bool is_byte(float number) {
  return number >= 0 && number <= 255 && std::trunc(number) == number;  // no NaN passes
}

/// @param command  COMMAND_LONG or COMMAND_INT
template <class Command>
std::optional<FailureCommand> read(const Command& command) {
  if (command.command != MavCmd::kInjectFailure) return std::nullopt;
  return FailureCommand{.target = {command.target_system, command.target_component},
                        .order = failure_order(command.param1, command.param2, command.param3)};
}

}  // namespace

std::optional<FailureCommand> failure_command(const PacketView& packet) {
  if (const auto command = decode<CommandLong>(packet)) return read(*command);
  if (const auto placed = decode<CommandInt>(packet)) return read(*placed);
  return std::nullopt;
}

std::optional<FailureOrder> failure_order(float unit, float type, float instance) {
  if (std::isnan(instance)) instance = 0;  // so it is sent by stations that mean none
  if (!is_byte(unit) || !is_byte(type) || !is_byte(instance)) return std::nullopt;
  return FailureOrder{.unit = static_cast<FailureUnit>(static_cast<std::uint8_t>(unit)),
                      .type = static_cast<FailureType>(static_cast<std::uint8_t>(type)),
                      .instance = static_cast<std::uint8_t>(instance)};
}

CommandLong command_of(const FailureOrder& order, Source target) {
  CommandLong message;
  message.target_system = target.system;
  message.target_component = target.component;
  message.command = MavCmd::kInjectFailure;
  message.param1 = static_cast<float>(order.unit);
  message.param2 = static_cast<float>(order.type);
  message.param3 = static_cast<float>(order.instance);
  return message;
}

std::string to_words(FailureUnit unit) { return word_of(kUnits, unit); }

std::string to_words(const FailureOrder& order) {
  std::string words = to_words(order.unit) + " " + word_of(kTypes, order.type);
  if (order.instance > 0) words += ", instance " + std::to_string(order.instance);
  return words;
}

}  // namespace cas::mav::services
