// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/writers.hpp"

#include <string_view>

namespace cas::mav::gen {
namespace {

/// Writes members and elements one a line, with the commas where they belong.
class JsonWriter final {
 public:
  void open(std::string_view key, char bracket) {
    begin(key);
    out_ += bracket;
    first_ = true;
    ++depth_;
  }

  void close(char bracket) {
    --depth_;
    if (!first_) line();
    out_ += bracket;
    first_ = false;
  }

  void number(std::string_view key, std::string_view value) {
    begin(key);
    out_ += value;
  }

  void number(std::string_view key, std::size_t value) { number(key, std::to_string(value)); }

  void text(std::string_view key, std::string_view value) {
    begin(key);
    quote(value);
  }

  /// Like text() and flag(), but omits an empty or false value.
  void text_if(std::string_view key, std::string_view value) {
    if (!value.empty()) text(key, value);
  }
  void flag_if(std::string_view key, bool value) {
    if (value) number(key, "true");
  }

  std::string take() {
    out_ += '\n';
    return std::move(out_);
  }

 private:
  void line() {
    out_ += '\n';
    out_.append(static_cast<std::size_t>(depth_), ' ');
  }

  void begin(std::string_view key) {
    if (!first_) out_ += ',';
    if (depth_ > 0) line();
    first_ = false;
    if (key.empty()) return;
    quote(key);
    out_ += ": ";
  }

  void quote(std::string_view value) {
    constexpr std::string_view kHex = "0123456789abcdef";
    out_ += '"';
    for (const char c : value) {
      const auto byte = static_cast<unsigned char>(c);
      if (byte < 0x20U) {
        out_ += cat({"\\u00", kHex.substr(byte >> 4U, 1), kHex.substr(byte & 15U, 1)});
        continue;
      }
      if (c == '"' || c == '\\') out_ += '\\';
      out_ += c;
    }
    out_ += '"';
  }

  std::string out_;
  int depth_{};
  bool first_{true};
};

void write_lifecycle(JsonWriter& json, const xml::Lifecycle& lifecycle) {
  if (lifecycle.status == xml::Status::kStable) return;
  json.open("lifecycle", '{');
  json.text("status", lifecycle.status == xml::Status::kWip          ? "wip"
                      : lifecycle.status == xml::Status::kSuperseded ? "superseded"
                                                                     : "deprecated");
  json.text_if("since", lifecycle.since);
  json.text_if("replaced_by", lifecycle.replaced_by);
  json.text_if("description", lifecycle.text);
  json.close('}');
}

void write_param(JsonWriter& json, const xml::Param& param) {
  json.open("", '{');
  json.number("index", static_cast<std::size_t>(param.index));
  json.text_if("label", param.label);
  json.text_if("units", param.units);
  json.text_if("enum", param.enum_name);
  json.text_if("min", param.min_value);
  json.text_if("max", param.max_value);
  json.text_if("increment", param.increment);
  json.text_if("default", param.default_value);
  json.flag_if("reserved", param.reserved);
  json.text_if("description", param.text);
  json.close('}');
}

void write_enum(JsonWriter& json, const xml::Enum& item) {
  json.open("", '{');
  json.text("name", item.name);
  json.flag_if("bitmask", item.bitmask);
  json.number("bytes", static_cast<std::size_t>(item.bytes));
  json.flag_if("signed", item.is_signed);
  json.text_if("description", item.text);
  write_lifecycle(json, item.lifecycle);
  json.open("entries", '[');
  for (const auto& entry : item.entries) {
    json.open("", '{');
    json.text("name", entry.name);
    json.number("value", entry.value.decimal());
    json.text_if("description", entry.text);
    write_lifecycle(json, entry.lifecycle);
    json.flag_if("has_location", entry.has_location);
    json.flag_if("is_destination", entry.is_destination);
    json.flag_if("mission_only", entry.mission_only);
    if (!entry.params.empty()) {
      json.open("params", '[');
      for (const auto& param : entry.params) write_param(json, param);
      json.close(']');
    }
    json.close('}');
  }
  json.close(']');
  json.close('}');
}

void write_field(JsonWriter& json, const xml::Field& field) {
  json.open("", '{');
  json.text("name", field.name);
  json.text("type", xml::wire_name(field.type));
  if (field.array_length > 0) json.number("array", static_cast<std::size_t>(field.array_length));
  json.number("offset", field.offset);
  json.flag_if("extension", field.extension);
  if (field.is_version) json.number("constant", std::size_t{field.version});
  json.text_if("enum", field.enum_name);
  json.text_if("units", field.units);
  json.text_if("multiplier", field.multiplier);
  json.text_if("invalid", field.invalid);
  json.text_if("default", field.default_value);
  json.text_if("min", field.min_value);
  json.text_if("max", field.max_value);
  json.text_if("print_format", field.print_format);
  json.flag_if("instance", field.instance);
  json.text_if("description", field.text);
  json.close('}');
}

void write_message(JsonWriter& json, const xml::Message& message) {
  json.open("", '{');
  json.number("id", std::size_t{message.id});
  json.text("name", message.name);
  json.number("crc_extra", std::size_t{message.crc_extra});
  json.number("min_length", message.min_length);
  json.number("max_length", message.max_length);
  json.text_if("description", message.text);
  write_lifecycle(json, message.lifecycle);
  json.open("fields", '[');
  for (const auto& field : message.fields) write_field(json, field);
  json.close(']');
  json.close('}');
}

}  // namespace

std::string write_json(const xml::Dialect& dialect) {
  JsonWriter json;
  json.open("", '{');
  json.number("schema", std::size_t{1});
  json.text("dialect", dialect.name);
  json.number("version", static_cast<std::size_t>(dialect.version));
  json.number("number", static_cast<std::size_t>(dialect.number));
  json.open("enums", '[');
  for (const auto& item : dialect.enums) write_enum(json, item);
  json.close(']');
  json.open("messages", '[');
  for (const auto& message : dialect.messages) write_message(json, message);
  json.close(']');
  json.close('}');
  return json.take();
}

}  // namespace cas::mav::gen
