// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cas::sim {

/// A MAVLink message that a plugin sends to the flight controller: id and payload. The interface
/// plugin adds sender (system, component), sequence and checksum.
struct MavlinkMessage {
  static constexpr std::string_view kTypeName = "cas.MavlinkMessage";
  static constexpr unsigned kTypeVersion = 1;
  std::uint32_t id = 0;
  std::array<std::uint8_t, 255> payload{};  ///< fields in wire order, extensions included
  std::size_t size = 0;                     ///< bytes of the payload; missing ones count as zeros
};

/// A message of the generated headers ("mavlink/common/battery_status.hpp", cas::mavlink) as it is
/// published.
template <class Message>
MavlinkMessage mavlink_message(const Message& message) {
  static_assert(Message::kMaxLength <= sizeof(MavlinkMessage::payload));
  MavlinkMessage result;
  result.id = Message::kId;
  result.size = Message::kMaxLength;
  message.pack(result.payload.data());
  return result;
}

/// A plugin that declares MAVLink messages, as an interface plugin sees it.
struct MavlinkSender {
  std::string plugin;                 ///< "battery", or "battery#2" for a twin
  std::string topic;                  ///< on which it publishes MavlinkMessage
  std::vector<std::string> messages;  ///< names or ids, as CAS_PLUGIN_SENDS has them
};

}  // namespace cas::sim

/// Declares the MAVLink messages that the plugin of this library sends, by name or id, beside
/// CAS_PLUGIN: `CAS_PLUGIN_SENDS("BATTERY_STATUS", "OPTICAL_FLOW")`. Only these leave the
/// simulator, and `hils run` lets exactly these pass to the controller. Exports
/// cas_plugin_sends_v1.
#define CAS_PLUGIN_SENDS(...)                                                                 \
  extern "C" __attribute__((visibility("default"))) const char* const* cas_plugin_sends_v1(); \
  extern "C" const char* const* cas_plugin_sends_v1() {                                       \
    static const char* const messages[] = {__VA_ARGS__, nullptr};                             \
    return messages;                                                                          \
  }
