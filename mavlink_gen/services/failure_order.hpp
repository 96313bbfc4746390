// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "mavlink/common/command_long.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav::services {

/// Unit that fails, by its number on the wire. Source: [MAVLink] FAILURE_UNIT.
enum class FailureUnit : std::uint8_t {
  kGyro = 0,
  kAccel = 1,
  kMag = 2,
  kBaro = 3,
  kGps = 4,
  kOpticalFlow = 5,
  kVio = 6,
  kDistanceSensor = 7,
  kAirspeed = 8,
  kBattery = 100,
  kMotor = 101,
  kServo = 102,
  kAvoidance = 103,
  kRcSignal = 104,
  kMavlinkSignal = 105,
};

/// How it fails, by its number on the wire. Source: [MAVLink] FAILURE_TYPE.
enum class FailureType : std::uint8_t {
  kOk = 0,  ///< ends the failure
  kOff = 1,
  kStuck = 2,
  kGarbage = 3,
  kWrong = 4,
  kSlow = 5,
  kDelayed = 6,
  kIntermittent = 7,
};

/// MAV_CMD_INJECT_FAILURE without its addressee. Numbers that MAVLink does not name are kept.
struct FailureOrder {
  FailureUnit unit{};
  FailureType type{};
  std::uint8_t instance = 0;  ///< from 1; 0: all of them

  friend bool operator==(const FailureOrder&, const FailureOrder&) = default;
};

/// The same as it was received.
struct FailureCommand {
  Source target{};                      ///< system 0: none was named
  std::optional<FailureOrder> order{};  ///< nullopt: a number is not whole, or not from 0 to 255
};

/// Why a simulator does not take a failure: `progress` of its COMMAND_ACK, where MAVLink lets the
/// reason of a refusal stand. The numbers are CAS's own; [MAVLink] names none. Source: [MAVLink]
/// COMMAND_ACK.
enum class FailureRefusal : std::uint8_t {
  kNotSaid = 0,
  kUnit = 1,      ///< it has no physics for this unit
  kType = 2,      ///< the unit does not fail in this way
  kPart = 3,      ///< the vehicle has no such part, or it has not spoken yet
  kInstance = 4,  ///< the vehicle has fewer of them
  kByHand = 5,    ///< nothing there takes failures while it runs
  kFull = 6,      ///< the run takes no more of them
};

/// Most that tells an order from the next in parameter 7: the whole numbers that a float tells
/// apart.
inline constexpr std::int32_t kMostToken = 1 << 24;

/// Reads MAV_CMD_INJECT_FAILURE, as COMMAND_LONG or COMMAND_INT; nullopt for other packets.
std::optional<FailureCommand> failure_command(const PacketView& packet);
/// Reads parameters 1 to 3 of the command; nothing as above.
std::optional<FailureOrder> failure_order(float unit, float type, float instance);
/// The command for this addressee.
mavlink::common::CommandLong command_of(const FailureOrder& order, Source target);

/// The words of PX4's command `failure`: "gps", "gps off", "motor off, instance 2".
std::string to_words(FailureUnit unit);
std::string to_words(const FailureOrder& order);

}  // namespace cas::mav::services
