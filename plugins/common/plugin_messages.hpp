// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "libsim/api/plugin.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/message_table.hpp"

namespace cas::sim {

/// Component of the simulator's own packets.
inline constexpr std::uint8_t kSimulatorComponent = 200;

/// Hears the messages of a vehicle's plugins. To be called in `configure`.
/// @param on_message  gets the sender's place in `senders`
std::vector<Subscription> hear_plugins(
    TopicBus& bus, const std::vector<MavlinkSender>& senders,
    const std::function<void(std::size_t, const MavlinkMessage&)>& on_message);

/// The public message of this name or id, as a plugin declares it.
/// @throws base::ConfigError for an unknown message, and for one that the simulator itself sends or
/// takes
const mav::MessageInfo& declared_message(const std::string& word);

/// Packs a message as an unsigned MAVLink 2 packet, trailing zeros cut. @return bytes written
std::size_t encode_message(const mav::MessageInfo& info, const MavlinkMessage& message,
                           mav::Source source, std::uint8_t sequence,
                           std::span<std::uint8_t, mav::kMaxPacketBytes> out);

/// Filters the messages that the plugins of a vehicle publish. A message goes out if its plugin
/// declares it, its size is right, and it comes at most 250 times in a second of simulated time.
/// Refused messages are counted.
class PluginMessages {
 public:
  static constexpr unsigned kMostPerSecond = 250;

  PluginMessages() = default;
  /// @throws base::ConfigError that names the plugin, as declared_message()
  explicit PluginMessages(const std::vector<MavlinkSender>& senders);

  /// The message's entry in the table; null when it is refused.
  /// @param sender  index in `senders`
  /// @param refusal  set to a sentence once for each plugin and reason; else unchanged
  const mav::MessageInfo* admit(std::size_t sender, const MavlinkMessage& message,
                                base::SimTime now, std::string& refusal);

  /// Back to time zero; clears the refusal counters.
  void reset();
  std::uint64_t refused() const;
  /// {"battery":{"declares":["BATTERY_STATUS"],"undeclared":0,"wrong_size":0,"too_often":0}}
  nlohmann::ordered_json json() const;

 private:
  enum Reason : std::size_t { kUndeclared, kWrongSize, kTooOften, kReasons };
  struct Declared {
    const mav::MessageInfo* info;
    std::int64_t second = -1;  ///< of simulated time, in which `count` were admitted
    unsigned count = 0;
  };
  struct Sender {
    std::string plugin;
    std::vector<Declared> declared;
    std::uint64_t refused[kReasons] = {};
  };

  const mav::MessageInfo* refuse(Sender& sender, Reason reason, std::uint32_t id,
                                 std::string& refusal);

  std::vector<Sender> senders_;
};

}  // namespace cas::sim
