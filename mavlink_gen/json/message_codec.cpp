// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/json/message_codec.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/suggestion.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/enum_text.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/services/param_exchange.hpp"

namespace cas::mav::services {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

std::size_t size_of(FieldType type) {
  switch (type) {
    case FieldType::kChar:
    case FieldType::kUint8:
    case FieldType::kInt8:
      return 1;
    case FieldType::kUint16:
    case FieldType::kInt16:
      return 2;
    case FieldType::kUint32:
    case FieldType::kInt32:
    case FieldType::kFloat:
      return 4;
    case FieldType::kUint64:
    case FieldType::kInt64:
    case FieldType::kDouble:
      return 8;
  }
  return 1;
}

/// A number at an offset; bytes that a truncated payload lacks are zero.
template <class Wire>
Wire load(std::span<const std::uint8_t> payload, std::size_t offset) {
  std::array<std::uint8_t, sizeof(Wire)> bytes{};
  for (std::size_t i = 0; i < bytes.size() && offset + i < payload.size(); ++i) {
    bytes[i] = payload[offset + i];
  }
  Wire value{};
  get<Wire>(bytes.data(), value);
  return value;
}

json element_json(FieldType type, std::span<const std::uint8_t> payload, std::size_t offset) {
  switch (type) {
    case FieldType::kChar:
    case FieldType::kUint8:
      return load<std::uint8_t>(payload, offset);
    case FieldType::kInt8:
      return load<std::int8_t>(payload, offset);
    case FieldType::kUint16:
      return load<std::uint16_t>(payload, offset);
    case FieldType::kInt16:
      return load<std::int16_t>(payload, offset);
    case FieldType::kUint32:
      return load<std::uint32_t>(payload, offset);
    case FieldType::kInt32:
      return load<std::int32_t>(payload, offset);
    case FieldType::kUint64:
      return load<std::uint64_t>(payload, offset);
    case FieldType::kInt64:
      return load<std::int64_t>(payload, offset);
    case FieldType::kFloat:
      return number_json(static_cast<double>(load<float>(payload, offset)));
    case FieldType::kDouble: {
      const auto value = load<double>(payload, offset);
      return std::isfinite(value) ? json(value) : json();
    }
  }
  return nullptr;
}

/// Throws the sentence on a wrong value.
[[noreturn]] void refuse(const std::string& field, const json& value, const std::string& why) {
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  throw std::invalid_argument(field + ": " + text + " " + why);
}

/// A character as write_json gives it: bytes that are not ASCII stand for Latin-1.
void append_utf8(char c, std::string& text) {
  const auto byte = static_cast<std::uint8_t>(c);
  if (byte < 0x80) {
    text += c;
  } else {
    text += static_cast<char>(0xC0U | byte >> 6U);
    text += static_cast<char>(0x80U | (byte & 0x3FU));
  }
}

/// The inverse; nullopt for characters beyond Latin-1 and for invalid UTF-8.
std::optional<std::string> latin1(std::string_view utf8) {
  std::string bytes;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto lead = static_cast<std::uint8_t>(utf8[i]);
    if (lead < 0x80) {
      bytes += utf8[i];
      continue;
    }
    if ((lead != 0xC2 && lead != 0xC3) || ++i == utf8.size()) return std::nullopt;
    const auto next = static_cast<std::uint8_t>(utf8[i]);
    if (next >> 6U != 2) return std::nullopt;
    bytes += static_cast<char>((lead & 3U) << 6U | (next & 0x3FU));
  }
  return bytes;
}

/// Stores a number where its type can hold it.
template <class Wire>
void store_number(const std::string& field, const json& value, std::uint8_t* out) {
  if constexpr (std::is_floating_point_v<Wire>) {
    if (!value.is_number() && !value.is_null()) refuse(field, value, "is no number");
    const double number =
        value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
    if (std::abs(number) > static_cast<double>(std::numeric_limits<Wire>::max())) {
      refuse(field, value, "is too large");
    }
    put<Wire>(out, number);
  } else {
    if (!value.is_number_integer()) refuse(field, value, "is no whole number");
    const bool fits = value.is_number_unsigned() ? std::in_range<Wire>(value.get<std::uint64_t>())
                                                 : std::in_range<Wire>(value.get<std::int64_t>());
    if (!fits) refuse(field, value, "does not fit into the field");
    put<Wire>(out, value.get<Wire>());
  }
}

void store_element(const std::string& field, FieldType type, const json& value, std::uint8_t* out) {
  switch (type) {
    case FieldType::kChar:
    case FieldType::kUint8:
      return store_number<std::uint8_t>(field, value, out);
    case FieldType::kInt8:
      return store_number<std::int8_t>(field, value, out);
    case FieldType::kUint16:
      return store_number<std::uint16_t>(field, value, out);
    case FieldType::kInt16:
      return store_number<std::int16_t>(field, value, out);
    case FieldType::kUint32:
      return store_number<std::uint32_t>(field, value, out);
    case FieldType::kInt32:
      return store_number<std::int32_t>(field, value, out);
    case FieldType::kUint64:
      return store_number<std::uint64_t>(field, value, out);
    case FieldType::kInt64:
      return store_number<std::int64_t>(field, value, out);
    case FieldType::kFloat:
      return store_number<float>(field, value, out);
    case FieldType::kDouble:
      return store_number<double>(field, value, out);
  }
}

/// The bits of an integer of JSON, as two's complement.
std::uint64_t bits_of(const json& number) {
  return number.is_number_unsigned() ? number.get<std::uint64_t>()
                                     : static_cast<std::uint64_t>(number.get<std::int64_t>());
}

}  // namespace

json number_json(double value) {
  constexpr double kExact = 9007199254740992;  // 2^53
  if (!std::isfinite(value)) return nullptr;
  if (value == std::floor(value) && std::abs(value) < kExact) {
    return static_cast<std::int64_t>(value);
  }
  return std::strtod(number_text(value).c_str(), nullptr);
}

MessageCodec::MessageCodec() {
  namespace common = mavlink::common;
  for (const EnumInfo& from : common::enums()) {
    Enum& to = enums_[std::string(from.name)];
    to.bitmask = from.bitmask;
    for (const EnumEntry& entry : from.entries) to.entries.emplace_back(entry.name, entry.value);
  }
  for (const MessageInfo& from : common::table().all()) {
    Message& to = messages_[from.id];
    to.name = std::string(from.name);
    to.crc_extra = from.crc_extra;
    to.empty.resize(from.max_length);
    common::dispatch(PacketView{.message_id = from.id},
                     [&]<class M>(const M&) { M{}.pack(to.empty.data()); });
    for (const FieldInfo& field : common::fields_of(from.id)) {
      to.fields.push_back({.name = std::string(field.name),
                           .units = std::string(field.units),
                           .enum_name = std::string(field.enum_name),
                           .type = field.type,
                           .array_length = field.array_length,
                           .wire_offset = field.wire_offset});
    }
  }
}

void MessageCodec::add(const xml::Dialect& dialect) {
  for (const xml::Enum& from : dialect.enums) {
    Enum to{.bitmask = from.bitmask, .entries = {}};
    for (const xml::Entry& entry : from.entries) {
      to.entries.emplace_back(entry.name, entry.value.bits);
    }
    enums_[from.name] = std::move(to);
  }
  std::set<std::string_view> names;
  for (const xml::Message& message : dialect.messages) names.insert(message.name);
  std::erase_if(messages_, [&](const auto& known) { return names.contains(known.second.name); });
  for (const xml::Message& from : dialect.messages) {
    Message to{.name = from.name,
               .crc_extra = from.crc_extra,
               .empty = std::vector<std::uint8_t>(from.max_length),
               .fields = {}};
    for (const xml::Field& field : from.fields) {
      if (field.is_version) to.empty[field.offset] = field.version;
      // FieldType and the parser's enumeration have the wire types in the same order.
      to.fields.push_back({.name = field.name,
                           .units = field.units,
                           .enum_name = field.enum_name,
                           .type = static_cast<FieldType>(field.type),
                           .array_length = static_cast<std::size_t>(field.array_length),
                           .wire_offset = field.offset});
    }
    messages_[from.id] = std::move(to);
  }
}

ordered_json MessageCodec::to_json(const PacketView& packet) const {
  const auto found = messages_.find(packet.message_id);
  if (found == messages_.end()) return nullptr;
  ordered_json object{{"message", found->second.name}};
  for (const Field& field : found->second.fields) {
    object[field.name] = value_json(field, packet.payload, true);
  }
  return object;
}

PacketBuffer MessageCodec::from_json(const ordered_json& object, Source source,
                                     std::uint8_t sequence) const {
  if (!object.is_object() || !object.contains("message") || !object["message"].is_string()) {
    throw std::invalid_argument("a message is an object with its name under \"message\"");
  }
  const auto wanted = object["message"].get<std::string>();
  const std::optional<std::uint32_t> id = find(wanted);
  if (!id) throw std::invalid_argument("there is no message " + wanted);
  const Message& message = messages_.at(*id);

  PacketBuffer packet;
  std::uint8_t* payload = packet.bytes.data() + kHeaderBytesV2;
  std::ranges::copy(message.empty, payload);
  for (const auto& [key, value] : object.items()) {
    if (key == "message") continue;
    const auto field = std::ranges::find(message.fields, key, &Field::name);
    if (field == message.fields.end()) {
      std::vector<std::string_view> known;
      for (const Field& each : message.fields) known.push_back(each.name);
      throw std::invalid_argument(wanted + " has no field '" + key + "'" +
                                  base::did_you_mean(key, known));
    }
    store(*field, value, payload);
  }
  const std::size_t length = truncated_length({payload, message.empty.size()});
  const std::uint8_t header[] = {kStartV2,
                                 static_cast<std::uint8_t>(length),
                                 0,
                                 0,
                                 sequence,
                                 source.system,
                                 source.component,
                                 static_cast<std::uint8_t>(*id & 0xFFU),
                                 static_cast<std::uint8_t>(*id >> 8U & 0xFFU),
                                 static_cast<std::uint8_t>(*id >> 16U)};
  std::ranges::copy(header, packet.bytes.begin());
  packet.size =
      detail::append_checksum(packet.bytes.data(), kHeaderBytesV2 + length, message.crc_extra);
  return packet;
}

json MessageCodec::fields(std::uint32_t message_id, Payload payload) const {
  json all = json::array();
  const auto found = messages_.find(message_id);
  if (found == messages_.end()) return all;
  for (const Field& field : found->second.fields) {
    json entry{{"name", field.name}, {"value", value_json(field, payload, false)}};
    if (!field.units.empty()) entry["units"] = field.units;
    all.push_back(std::move(entry));
  }
  return all;
}

json MessageCodec::value_json(const Field& field, Payload payload, bool enums_by_name) const {
  if (field.type == FieldType::kChar) {
    std::string text;
    for (std::size_t i = 0; i < std::max<std::size_t>(field.array_length, 1); ++i) {
      const auto c = load<char>(payload, field.wire_offset + i);
      if (c == '\0') break;
      append_utf8(c, text);
    }
    return text;
  }
  const Enum* names = enums_by_name ? enum_of(field) : nullptr;
  const auto element = [&](std::size_t i) {
    const json number =
        element_json(field.type, payload, field.wire_offset + i * size_of(field.type));
    return names == nullptr ? number : enum_json(*names, number);
  };
  if (field.array_length == 0) return element(0);
  json values = json::array();
  for (std::size_t i = 0; i < field.array_length; ++i) values.push_back(element(i));
  return values;
}

/// The name of a value, or of the flags in it; the number where it has none.
json MessageCodec::enum_json(const Enum& names, const json& number) const {
  const std::uint64_t bits = bits_of(number);
  for (const auto& [name, value] : names.entries) {
    if (value == bits) return name;
  }
  if (!names.bitmask || bits == 0) return number;
  std::string words;
  std::uint64_t left = bits;
  for (const auto& [name, value] : names.entries) {
    if (value == 0 || (value & left) != value) continue;
    words += (words.empty() ? "" : "|") + name;
    left &= ~value;
  }
  if (left != 0) words += (words.empty() ? "" : "|") + std::to_string(left);
  return words;
}

void MessageCodec::store(const Field& field, const json& value, std::uint8_t* payload) const {
  std::uint8_t* out = payload + field.wire_offset;
  if (field.type == FieldType::kChar) {
    if (!value.is_string()) refuse(field.name, value, "is no text");
    const auto text = latin1(value.get_ref<const std::string&>());
    if (!text) refuse(field.name, value, "has a character that is no byte of Latin-1");
    const std::size_t room = std::max<std::size_t>(field.array_length, 1);
    if (text->size() > room) {
      refuse(field.name, value, "is longer than " + std::to_string(room) + " characters");
    }
    std::ranges::copy(*text, out);
    return;
  }
  const auto put_element = [&](const json& element, std::size_t i) {
    const bool is_words = element.is_string();
    store_element(field.name, field.type,
                  is_words ? enum_number(field, element.get<std::string>()) : element,
                  out + i * size_of(field.type));
  };
  if (field.array_length == 0) return put_element(value, 0);
  if (!value.is_array() || value.size() > field.array_length) {
    refuse(field.name, value,
           "is no list of at most " + std::to_string(field.array_length) + " values");
  }
  for (std::size_t i = 0; i < value.size(); ++i) put_element(value[i], i);
}

/// The number that names joined by '|' stand for; a part may be a number.
json MessageCodec::enum_number(const Field& field, const std::string& words) const {
  const Enum* names = enum_of(field);
  if (names == nullptr) refuse(field.name, words, "is no number");
  std::uint64_t bits = 0;
  for (std::size_t at = 0; at <= words.size();) {
    const std::size_t end = std::min(words.find('|', at), words.size());
    const std::string word = words.substr(at, end - at);
    at = end + 1;
    const auto entry =
        std::ranges::find(names->entries, word, &decltype(Enum::entries)::value_type::first);
    std::uint64_t number = 0;
    if (entry != names->entries.end()) {
      number = entry->second;
    } else if (const auto read = std::from_chars(word.data(), word.data() + word.size(), number);
               read.ec != std::errc() || read.ptr != word.data() + word.size()) {
      std::vector<std::string_view> known;
      for (const auto& [name, value] : names->entries) known.push_back(name);
      refuse(field.name, word,
             "is no entry of " + field.enum_name + base::did_you_mean(word, known));
    }
    bits |= number;
  }
  const bool is_signed = field.type == FieldType::kInt8 || field.type == FieldType::kInt16 ||
                         field.type == FieldType::kInt32 || field.type == FieldType::kInt64;
  return is_signed ? json(static_cast<std::int64_t>(bits)) : json(bits);
}

const MessageCodec::Enum* MessageCodec::enum_of(const Field& field) const {
  const bool whole = field.type != FieldType::kFloat && field.type != FieldType::kDouble;
  const auto found = whole ? enums_.find(field.enum_name) : enums_.end();
  return found == enums_.end() ? nullptr : &found->second;
}

std::optional<std::uint32_t> MessageCodec::find(std::string_view name) const {
  for (const auto& [id, message] : messages_) {
    if (message.name == name) return id;
  }
  return std::nullopt;
}

std::string MessageCodec::name(std::uint32_t message_id) const {
  const auto found = messages_.find(message_id);
  return found == messages_.end() ? std::string() : found->second.name;
}

}  // namespace cas::mav::services
