// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/plugin_messages.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::sim {

namespace {

/// Their stamps and counts are those of the loop: a second sender would break its accounts. By the
/// true motion a controller in HITL would fly instead of by its sensors.
constexpr std::array<std::string_view, 7> kOfTheLoop{
    "HEARTBEAT",           "HIL_SENSOR", "HIL_GPS",
    "HIL_CONTROLS",        "HIL_STATE",  "HIL_ACTUATOR_CONTROLS",
    "HIL_STATE_QUATERNION"};

const mav::MessageInfo* find_message(const std::string& word) {
  std::uint32_t id = 0;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), id);
  const bool is_id = read.ec == std::errc() && read.ptr == word.data() + word.size();
  return is_id ? mav::public_table().find(id) : mav::public_table().find(word);
}

std::string name_of(std::uint32_t id) {
  const mav::MessageInfo* info = mav::public_table().find(id);
  return info != nullptr ? std::string(info->name) : "message " + std::to_string(id);
}

}  // namespace

const mav::MessageInfo& declared_message(const std::string& word) {
  const mav::MessageInfo* info = find_message(word);
  if (info == nullptr) {
    throw base::ConfigError("declares " + word +
                            ", which is no message of the public MAVLink dialects");
  }
  if (std::ranges::find(kOfTheLoop, std::string_view(info->name)) != kOfTheLoop.end()) {
    throw base::ConfigError("declares " + std::string(info->name) +
                            ", which the loop of simulator and controller has for itself");
  }
  return *info;
}

std::size_t encode_message(const mav::MessageInfo& info, const MavlinkMessage& message,
                           mav::Source source, std::uint8_t sequence,
                           std::span<std::uint8_t, mav::kMaxPacketBytes> out) {
  const std::size_t length = mav::truncated_length(std::span(message.payload).first(message.size));
  out[0] = mav::kStartV2;
  out[1] = static_cast<std::uint8_t>(length);
  out[2] = out[3] = 0;
  out[4] = sequence;
  out[5] = source.system;
  out[6] = source.component;
  out[7] = static_cast<std::uint8_t>(info.id & 0xFFU);
  out[8] = static_cast<std::uint8_t>(info.id >> 8U & 0xFFU);
  out[9] = static_cast<std::uint8_t>(info.id >> 16U);
  std::copy_n(message.payload.begin(), length, out.begin() + mav::kHeaderBytesV2);
  return mav::detail::append_checksum(out.data(), mav::kHeaderBytesV2 + length, info.crc_extra);
}

std::vector<Subscription> hear_plugins(
    TopicBus& bus, const std::vector<MavlinkSender>& senders,
    const std::function<void(std::size_t, const MavlinkMessage&)>& on_message) {
  std::vector<Subscription> subscriptions;
  for (std::size_t i = 0; i < senders.size(); ++i) {
    subscriptions.push_back(bus.subscribe<MavlinkMessage>(
        senders[i].topic,
        [on_message, i](const MavlinkMessage& message) { on_message(i, message); },
        Need::kOptional));
  }
  return subscriptions;
}

PluginMessages::PluginMessages(const std::vector<MavlinkSender>& senders) {
  for (const MavlinkSender& from : senders) {
    Sender& sender = senders_.emplace_back();
    sender.plugin = from.plugin;
    for (const std::string& word : from.messages) {
      try {
        sender.declared.push_back({.info = &declared_message(word)});
      } catch (const base::ConfigError& error) {
        throw base::ConfigError("plugin " + from.plugin + " " + error.what());
      }
    }
  }
}

const mav::MessageInfo* PluginMessages::admit(std::size_t sender, const MavlinkMessage& message,
                                              base::SimTime now, std::string& refusal) {
  Sender& from = senders_[sender];
  const auto known = std::ranges::find_if(
      from.declared, [&](const Declared& declared) { return declared.info->id == message.id; });
  if (known == from.declared.end()) return refuse(from, kUndeclared, message.id, refusal);
  if (message.size == 0 || message.size > known->info->max_length) {
    return refuse(from, kWrongSize, message.id, refusal);
  }
  const std::int64_t second =
      std::chrono::floor<std::chrono::seconds>(now.time_since_epoch()).count();
  if (second != known->second) {
    known->second = second;
    known->count = 0;
  }
  if (known->count == kMostPerSecond) return refuse(from, kTooOften, message.id, refusal);
  ++known->count;
  return known->info;
}

const mav::MessageInfo* PluginMessages::refuse(Sender& sender, Reason reason, std::uint32_t id,
                                               std::string& refusal) {
  if (sender.refused[reason]++ > 0) return nullptr;
  constexpr std::array<const char*, kReasons> kSentences{
      ", which it does not declare (CAS_PLUGIN_SENDS); it is not sent",
      " with a payload of a wrong size; it is not sent",
      " more than 250 times in a second; the rest is not sent"};
  refusal = "plugin " + sender.plugin + " publishes " + name_of(id) + kSentences[reason];
  return nullptr;
}

void PluginMessages::reset() {
  for (Sender& sender : senders_) {
    std::ranges::fill(sender.refused, 0);
    for (Declared& declared : sender.declared) declared = {.info = declared.info};
  }
}

std::uint64_t PluginMessages::refused() const {
  std::uint64_t sum = 0;
  for (const Sender& sender : senders_) {
    for (const std::uint64_t count : sender.refused) sum += count;
  }
  return sum;
}

nlohmann::ordered_json PluginMessages::json() const {
  using Json = nlohmann::ordered_json;
  Json plugins = Json::object();
  for (const Sender& sender : senders_) {
    Json declares = Json::array();
    for (const Declared& declared : sender.declared) declares.push_back(declared.info->name);
    plugins[sender.plugin] = {{"declares", std::move(declares)},
                              {"undeclared", sender.refused[kUndeclared]},
                              {"wrong_size", sender.refused[kWrongSize]},
                              {"too_often", sender.refused[kTooOften]}};
  }
  return plugins;
}

}  // namespace cas::sim
