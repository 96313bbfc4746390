// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/file_parser.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mavlink_gen/parser/model.hpp"
#include "mavlink_gen/parser/numbers.hpp"
#include "mavlink_gen/runtime/crc.hpp"

namespace cas::mav::xml {
namespace {

/// Most bytes a payload can have.
inline constexpr std::size_t kMaxPayloadBytes = 255;
/// Most fields a message can have.
inline constexpr std::size_t kMaxFields = 64;

std::vector<std::size_t> wire_order(const Message& message) {
  std::vector<std::size_t> order(message.fields.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto& left = message.fields[a];
    const auto& right = message.fields[b];
    if (left.extension != right.extension) return right.extension;
    return !left.extension && size_of(left.type) > size_of(right.type);
  });
  return order;
}

std::uint8_t crc_extra(const Message& message) {
  std::string text = message.name + ' ';
  for (const auto index : message.wire_order) {
    const auto& field = message.fields[index];
    if (field.extension) break;
    text += std::string(wire_name(field.type)) + ' ' + field.name + ' ';
    if (field.array_length > 0) text += static_cast<char>(field.array_length);
  }
  const auto crc =
      Crc16().update({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  return static_cast<std::uint8_t>((crc.value() & 0xFFU) ^ (crc.value() >> 8U));
}

/// Sets wire order, offsets, lengths and CRC_EXTRA from the fields.
///
/// Base fields go by the size of their element, largest first, otherwise as in the XML; extension
/// fields follow as in the XML, without padding. CRC_EXTRA covers the base fields alone.
void compute_layout(Message& message) {
  message.wire_order = wire_order(message);
  std::size_t offset = 0;
  message.min_length = 0;
  for (const auto index : message.wire_order) {
    auto& field = message.fields[index];
    field.offset = offset;
    offset += field.bytes();
    if (!field.extension) message.min_length = offset;
  }
  message.max_length = offset;
  message.crc_extra = crc_extra(message);
}

constexpr std::uint32_t kMaxMessageId = 0xFFFFFF;
constexpr std::uint32_t kMaxArrayLength = 255;

class MessageParser final {
 public:
  explicit MessageParser(ElementReader& reader) : reader_(reader) {}

  std::optional<Message> parse(const Element& element) {
    constexpr std::array<std::string_view, 2> kAttributes{"id", "name"};
    constexpr std::array<std::string_view, 6> kChildren{"description", "wip",   "superseded",
                                                        "deprecated",  "field", "extensions"};
    reader_.expect_attributes(element, kAttributes);
    Message message;
    message.position = element.position;
    message.name = reader_.require_name(element);
    const bool has_id = parse_id(element, message);
    std::set<std::string> names;
    bool extension = false;
    bool faulty = false;
    for (const auto& child : element.children) {
      if (!reader_.expect_child(element, child, kChildren)) {
        faulty = true;
      } else if (child.name == "extensions") {
        if (extension) reader_.error(child.position, "<extensions/> stands twice");
        extension = true;
      } else if (child.name == "field") {
        faulty = !parse_field(child, extension, names, message) || faulty;
      } else {
        reader_.parse_common_child(child, message.text, message.lifecycle);
      }
    }
    if (!has_id || message.name.empty() || faulty) return std::nullopt;
    if (!check_size(message)) return std::nullopt;
    return message;
  }

 private:
  bool parse_id(const Element& element, Message& message) {
    const auto* attribute = reader_.require(element, "id");
    if (attribute == nullptr) return false;
    const auto id = parse_number(trimmed(attribute->value), kMaxMessageId);
    if (!id) {
      reader_.error(attribute->position, in_quotes(attribute->value) + " is no message id: 0 to " +
                                             std::to_string(kMaxMessageId));
      return false;
    }
    message.id = *id;
    return true;
  }

  bool check_size(Message& message) {
    const auto has_base = std::any_of(message.fields.begin(), message.fields.end(),
                                      [](const Field& field) { return !field.extension; });
    if (!has_base) {
      reader_.error(message.position, "message " + message.name + " has no base field");
      return false;
    }
    if (message.fields.size() > kMaxFields) {
      reader_.error(
          message.fields[kMaxFields].position,
          "message " + message.name + " has more than " + std::to_string(kMaxFields) + " fields");
      return false;
    }
    compute_layout(message);
    if (message.max_length > kMaxPayloadBytes) {
      reader_.error(message.position, "message " + message.name + " needs " +
                                          std::to_string(message.max_length) +
                                          " bytes, a payload has at most 255");
      return false;
    }
    return true;
  }

  bool parse_field(const Element& element, bool extension, std::set<std::string>& names,
                   Message& message) {
    constexpr std::array<std::string_view, 14> kAttributes{
        "type",    "name",    "enum",         "units",    "multiplier", "invalid",   "instance",
        "display", "default", "print_format", "minValue", "maxValue",   "increment", "resolution"};
    reader_.expect_attributes(element, kAttributes);
    for (const auto& child : element.children) {
      if (child.name != "description") reader_.expect_child(element, child, {});
    }
    Field field;
    field.position = element.position;
    field.extension = extension;
    field.name = reader_.require_name(element);
    const bool typed = parse_type(element, field);
    if (field.name.empty() || !typed) return false;
    if (!names.insert(field.name).second) {
      reader_.error(element.find("name")->position,
                    "message " + message.name + " has the field " + field.name + " twice");
      return false;
    }
    field.enum_name = ElementReader::value_of(element, "enum");
    field.units = ElementReader::value_of(element, "units");
    field.multiplier = ElementReader::value_of(element, "multiplier");
    field.invalid = ElementReader::value_of(element, "invalid");
    field.print_format = ElementReader::value_of(element, "print_format");
    field.default_value = ElementReader::value_of(element, "default");
    field.min_value = ElementReader::value_of(element, "minValue");
    field.max_value = ElementReader::value_of(element, "maxValue");
    field.display_bitmask = ElementReader::value_of(element, "display") == "bitmask";
    field.instance = reader_.parse_flag(element, "instance");
    field.text = prose(element.text);
    message.fields.push_back(std::move(field));
    return true;
  }

  /// Reads `type`, `type[n]`, the old `array[n]` and uint8_t_mavlink_version.
  bool parse_type(const Element& element, Field& field) {
    const auto* attribute = reader_.require(element, "type");
    if (attribute == nullptr) return false;
    const auto text = trimmed(attribute->value);
    auto base = std::string_view(text);
    if (const auto bracket = base.find('['); bracket != std::string_view::npos) {
      const auto closed = base.back() == ']';
      const auto digits = base.substr(bracket + 1, base.size() - bracket - 2);
      const auto length = closed ? parse_number(digits, kMaxArrayLength) : std::nullopt;
      if (!length || *length == 0) {
        reader_.error(attribute->position,
                      in_quotes(attribute->value) + " has no array length from 1 to 255");
        return false;
      }
      field.array_length = static_cast<int>(*length);
      base = base.substr(0, bracket);
    }
    if (base == "uint8_t_mavlink_version" && field.array_length == 0) {
      field.type = BaseType::kUint8;
      field.is_version = true;
      return true;
    }
    if (base == "array" && field.array_length > 0) base = "int8_t";
    std::vector<std::string_view> known;
    for (int i = 0; i <= static_cast<int>(BaseType::kDouble); ++i) {
      known.push_back(wire_name(static_cast<BaseType>(i)));
      if (known.back() != base) continue;
      field.type = static_cast<BaseType>(i);
      return true;
    }
    known.push_back("uint8_t_mavlink_version");
    reader_.error(attribute->position, "unknown type " + in_quotes(base) + suggestion(base, known));
    return false;
  }

  ElementReader& reader_;
};

}  // namespace

std::optional<Message> parse_message(const Element& element, ElementReader& reader) {
  return MessageParser(reader).parse(element);
}

}  // namespace cas::mav::xml
