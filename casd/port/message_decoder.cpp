// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/message_decoder.hpp"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "casd/port/call_json.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"

namespace cas::casd {
namespace {

using mav::FieldType;
using nlohmann::json;

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
  mav::get<Wire>(bytes.data(), value);
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

}  // namespace

void MessageDecoder::add_dialect(const std::filesystem::path& xml) {
  mav::xml::Diagnostics diagnostics;
  const auto dialect = mav::xml::load_dialect(xml, diagnostics);
  if (!dialect) throw base::ConfigError(diagnostics.render());
  for (const mav::xml::Message& from : dialect->messages) {
    Message message{.name = from.name, .fields = {}};
    for (const mav::xml::Field& field : from.fields) {
      // Both enumerations have the wire types in the same order.
      message.fields.push_back({.name = field.name,
                                .units = field.units,
                                .type = static_cast<FieldType>(field.type),
                                .array_length = static_cast<std::size_t>(field.array_length),
                                .wire_offset = field.offset});
    }
    messages_[from.id] = std::move(message);
  }
}

json MessageDecoder::fields(std::uint32_t message_id, std::span<const std::uint8_t> payload) const {
  json all = json::array();
  if (const auto found = messages_.find(message_id); found != messages_.end()) {
    for (const Field& field : found->second.fields) all.push_back(field_json(field, payload));
    return all;
  }
  for (const mav::FieldInfo& info : mavlink::common::fields_of(message_id)) {
    all.push_back(field_json({.name = std::string(info.name),
                              .units = std::string(info.units),
                              .type = info.type,
                              .array_length = info.array_length,
                              .wire_offset = info.wire_offset},
                             payload));
  }
  return all;
}

json MessageDecoder::field_json(const Field& field, std::span<const std::uint8_t> payload) {
  json entry{{"name", field.name}};
  if (!field.units.empty()) entry["units"] = field.units;
  if (field.array_length == 0) {
    entry["value"] = element_json(field.type, payload, field.wire_offset);
  } else if (field.type == FieldType::kChar) {
    std::string text;
    for (std::size_t i = 0; i < field.array_length; ++i) {
      const auto c = load<char>(payload, field.wire_offset + i);
      if (c == '\0') break;
      text += c;
    }
    entry["value"] = text;
  } else {
    entry["value"] = json::array();
    for (std::size_t i = 0; i < field.array_length; ++i) {
      entry["value"].push_back(
          element_json(field.type, payload, field.wire_offset + i * size_of(field.type)));
    }
  }
  return entry;
}

std::optional<std::uint32_t> MessageDecoder::find(std::string_view name) const {
  for (const auto& [id, message] : messages_) {
    if (message.name == name) return id;
  }
  return std::nullopt;
}

std::string MessageDecoder::name(std::uint32_t message_id) const {
  const auto found = messages_.find(message_id);
  return found == messages_.end() ? std::string() : found->second.name;
}

}  // namespace cas::casd
