// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/file_parser.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>

#include "mavlink_gen/parser/layout.hpp"
#include "mavlink_gen/parser/numbers.hpp"

namespace cas::mav::xml {
namespace {

constexpr std::uint32_t kMaxMessageId = 0xFFFFFF;
constexpr std::uint32_t kMaxArrayLength = 255;
constexpr std::uint32_t kMaxVersion = 255;
constexpr std::uint32_t kMaxDialectNumber = 0x7FFFFFFF;
constexpr int kMaxParams = 7;

using Names = std::span<const std::string_view>;

std::string trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const auto begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kSpace) - begin + 1));
}

/// Runs of white space become one blank.
std::string prose(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const bool space = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!space) out += c;
    if (space && !out.empty() && out.back() != ' ') out += ' ';
  }
  if (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

bool is_identifier(std::string_view name) {
  const auto is_letter = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
  };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !name.empty() && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return is_letter(c) || is_digit(c); });
}

std::string quoted(std::string_view text) { return '\'' + std::string(text) + '\''; }

class FileParser final {
 public:
  explicit FileParser(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  ParsedFile parse(const Element& root) {
    if (root.name != "mavlink") {
      diagnostics_.error(root.position, "the root element is <" + root.name + ">, not <mavlink>");
      return {};
    }
    constexpr std::array<std::string_view, 5> kChildren{"include", "version", "dialect", "enums",
                                                        "messages"};
    for (const auto& child : root.children) {
      if (!expect_child(root, child, kChildren)) continue;
      if (child.name == "include") parse_include(child);
      if (child.name == "version") parse_count(child, kMaxVersion, file_.version);
      if (child.name == "dialect") parse_count(child, kMaxDialectNumber, file_.dialect);
      if (child.name == "enums") parse_enums(child);
      if (child.name == "messages") parse_messages(child);
    }
    return std::move(file_);
  }

 private:
  // --- what every element shares ---------------------------------------------------------------

  bool expect_child(const Element& parent, const Element& child, Names allowed) {
    if (std::find(allowed.begin(), allowed.end(), child.name) != allowed.end()) return true;
    diagnostics_.error(child.position,
                       "<" + child.name + "> is not allowed in <" + parent.name + ">" +
                           suggestion(child.name, {allowed.begin(), allowed.end()}));
    return false;
  }

  void expect_attributes(const Element& element, Names allowed) {
    for (const auto& attribute : element.attributes) {
      if (std::find(allowed.begin(), allowed.end(), attribute.name) != allowed.end()) continue;
      if (attribute.name.find(':') != std::string::npos) continue;  // another XML vocabulary
      diagnostics_.warning(attribute.position,
                           "<" + element.name + "> has no attribute " + quoted(attribute.name) +
                               ", it is ignored" +
                               suggestion(attribute.name, {allowed.begin(), allowed.end()}));
    }
  }

  const Attribute* require(const Element& element, std::string_view name) {
    const auto* attribute = element.find(name);
    if (attribute == nullptr) {
      diagnostics_.error(element.position,
                         "<" + element.name + "> lacks the attribute " + quoted(name));
    }
    return attribute;
  }

  /// The attribute `name` as an identifier, empty after an error.
  std::string require_name(const Element& element) {
    const auto* attribute = require(element, "name");
    if (attribute == nullptr) return {};
    auto name = trimmed(attribute->value);
    if (is_identifier(name)) return name;
    diagnostics_.error(
        attribute->position,
        quoted(attribute->value) + " is no name: letters, digits and underscores, no digit first");
    return {};
  }

  static std::string value_of(const Element& element, std::string_view name) {
    const auto* attribute = element.find(name);
    return attribute == nullptr ? std::string() : trimmed(attribute->value);
  }

  bool parse_flag(const Element& element, std::string_view name) {
    const auto* attribute = element.find(name);
    if (attribute == nullptr) return false;
    const auto value = trimmed(attribute->value);
    if (value == "true" || value == "1") return true;
    if (value != "false" && value != "0") {
      diagnostics_.warning(attribute->position, quoted(attribute->value) + " for " + quoted(name) +
                                                    " is neither true nor false, false is taken");
    }
    return false;
  }

  void parse_count(const Element& element, std::uint32_t max, std::optional<int>& out) {
    expect_attributes(element, {});
    const auto text = trimmed(element.text);
    const auto value = parse_number(text, max);
    if (!value) {
      diagnostics_.error(element.text_position, "<" + element.name + "> holds " + quoted(text) +
                                                    ", not a number from 0 to " +
                                                    std::to_string(max));
    } else if (out) {
      diagnostics_.error(element.position, "<" + element.name + "> stands twice");
    } else {
      out = static_cast<int>(*value);
    }
  }

  void parse_include(const Element& element) {
    expect_attributes(element, {});
    auto path = trimmed(element.text);
    if (path.empty()) {
      diagnostics_.error(element.position, "<include> names no file");
    } else {
      file_.includes.push_back({std::move(path), element.position});
    }
  }

  Lifecycle parse_lifecycle(const Element& element) {
    constexpr std::array<std::string_view, 2> kAttributes{"since", "replaced_by"};
    expect_attributes(element, kAttributes);
    Lifecycle lifecycle;
    lifecycle.status = element.name == "wip"          ? Status::kWip
                       : element.name == "superseded" ? Status::kSuperseded
                                                      : Status::kDeprecated;
    lifecycle.since = value_of(element, "since");
    lifecycle.replaced_by = value_of(element, "replaced_by");
    lifecycle.text = prose(element.text);
    return lifecycle;
  }

  /// Handles the children that messages, enums and entries have in common.
  bool parse_common_child(const Element& child, std::string& text, Lifecycle& lifecycle) {
    if (child.name == "description") {
      text = prose(child.text);
      return true;
    }
    if (child.name == "wip" || child.name == "superseded" || child.name == "deprecated") {
      auto parsed = parse_lifecycle(child);
      // Of several the gravest counts, whatever their order.
      if (parsed.status > lifecycle.status) lifecycle = std::move(parsed);
      return true;
    }
    return false;
  }

  // --- enums -----------------------------------------------------------------------------------

  void parse_enums(const Element& element) {
    constexpr std::array<std::string_view, 1> kChildren{"enum"};
    for (const auto& child : element.children) {
      if (expect_child(element, child, kChildren)) parse_enum(child);
    }
  }

  void parse_enum(const Element& element) {
    constexpr std::array<std::string_view, 2> kAttributes{"name", "bitmask"};
    constexpr std::array<std::string_view, 5> kChildren{"description", "wip", "superseded",
                                                        "deprecated", "entry"};
    expect_attributes(element, kAttributes);
    Enum result;
    result.position = element.position;
    result.name = require_name(element);
    result.bitmask = parse_flag(element, "bitmask");
    std::optional<EnumValue> highest;
    for (const auto& child : element.children) {
      if (!expect_child(element, child, kChildren)) continue;
      if (parse_common_child(child, result.text, result.lifecycle)) continue;
      if (auto entry = parse_entry(child, highest)) {
        if (!highest || highest->less(entry->value)) highest = entry->value;
        result.entries.push_back(std::move(*entry));
      }
    }
    if (!result.name.empty()) file_.enums.push_back(std::move(result));
  }

  std::optional<Entry> parse_entry(const Element& element, std::optional<EnumValue> highest) {
    constexpr std::array<std::string_view, 5> kAttributes{"value", "name", "hasLocation",
                                                          "isDestination", "missionOnly"};
    constexpr std::array<std::string_view, 5> kChildren{"description", "wip", "superseded",
                                                        "deprecated", "param"};
    expect_attributes(element, kAttributes);
    Entry entry;
    entry.position = element.position;
    entry.name = require_name(element);
    entry.has_location = parse_flag(element, "hasLocation");
    entry.is_destination = parse_flag(element, "isDestination");
    entry.mission_only = parse_flag(element, "missionOnly");
    for (const auto& child : element.children) {
      if (!expect_child(element, child, kChildren)) continue;
      if (!parse_common_child(child, entry.text, entry.lifecycle)) parse_param(child, entry);
    }
    const auto value = parse_value(element, highest);
    if (!value || entry.name.empty()) return std::nullopt;
    entry.value = *value;
    return entry;
  }

  std::optional<EnumValue> parse_value(const Element& element, std::optional<EnumValue> highest) {
    const auto* attribute = element.find("value");
    if (attribute == nullptr) {
      if (!highest) return EnumValue{};
      const EnumValue next{highest->bits + 1, highest->negative && highest->bits + 1 != 0};
      if (highest->less(next)) return next;
      diagnostics_.error(element.position,
                         "the entry needs a value: none is left above the highest");
      return std::nullopt;
    }
    const auto value = parse_enum_value(trimmed(attribute->value));
    if (!value) {
      diagnostics_.error(
          attribute->position,
          quoted(attribute->value) + " is no enum value: decimal, 0x, 0b or 2**n, at most 64 bit");
    }
    return value;
  }

  void parse_param(const Element& element, Entry& entry) {
    constexpr std::array<std::string_view, 9> kAttributes{"index",     "label",    "units",
                                                          "enum",      "minValue", "maxValue",
                                                          "increment", "default",  "reserved"};
    expect_attributes(element, kAttributes);
    const auto* index = require(element, "index");
    if (index == nullptr) return;
    const auto number = parse_number(trimmed(index->value), kMaxParams);
    if (!number || *number == 0) {
      diagnostics_.error(index->position, quoted(index->value) + " is no parameter index: 1 to 7");
      return;
    }
    Param param;
    param.index = static_cast<int>(*number);
    const auto twice = std::any_of(entry.params.begin(), entry.params.end(),
                                   [&](const Param& p) { return p.index == param.index; });
    if (twice) {
      diagnostics_.error(index->position,
                         "parameter " + std::to_string(param.index) + " stands twice");
      return;
    }
    param.label = value_of(element, "label");
    param.units = value_of(element, "units");
    param.enum_name = value_of(element, "enum");
    param.min_value = value_of(element, "minValue");
    param.max_value = value_of(element, "maxValue");
    param.increment = value_of(element, "increment");
    param.default_value = value_of(element, "default");
    param.reserved = parse_flag(element, "reserved");
    param.text = prose(element.text);
    entry.params.push_back(std::move(param));
  }

  // --- messages --------------------------------------------------------------------------------

  void parse_messages(const Element& element) {
    constexpr std::array<std::string_view, 1> kChildren{"message"};
    for (const auto& child : element.children) {
      if (expect_child(element, child, kChildren)) parse_message(child);
    }
  }

  void parse_message(const Element& element) {
    constexpr std::array<std::string_view, 2> kAttributes{"id", "name"};
    constexpr std::array<std::string_view, 6> kChildren{"description", "wip",   "superseded",
                                                        "deprecated",  "field", "extensions"};
    expect_attributes(element, kAttributes);
    Message message;
    message.position = element.position;
    message.name = require_name(element);
    const bool has_id = parse_id(element, message);
    std::set<std::string> names;
    bool extension = false;
    bool faulty = false;
    for (const auto& child : element.children) {
      if (!expect_child(element, child, kChildren)) {
        faulty = true;
      } else if (child.name == "extensions") {
        if (extension) diagnostics_.error(child.position, "<extensions/> stands twice");
        extension = true;
      } else if (child.name == "field") {
        faulty = !parse_field(child, extension, names, message) || faulty;
      } else {
        parse_common_child(child, message.text, message.lifecycle);
      }
    }
    if (!has_id || message.name.empty() || faulty) return;
    if (check_size(message)) file_.messages.push_back(std::move(message));
  }

  bool parse_id(const Element& element, Message& message) {
    const auto* attribute = require(element, "id");
    if (attribute == nullptr) return false;
    const auto id = parse_number(trimmed(attribute->value), kMaxMessageId);
    if (!id) {
      diagnostics_.error(
          attribute->position,
          quoted(attribute->value) + " is no message id: 0 to " + std::to_string(kMaxMessageId));
      return false;
    }
    message.id = *id;
    return true;
  }

  bool check_size(Message& message) {
    const auto has_base = std::any_of(message.fields.begin(), message.fields.end(),
                                      [](const Field& field) { return !field.extension; });
    if (!has_base) {
      diagnostics_.error(message.position, "message " + message.name + " has no base field");
      return false;
    }
    if (message.fields.size() > kMaxFields) {
      diagnostics_.error(
          message.fields[kMaxFields].position,
          "message " + message.name + " has more than " + std::to_string(kMaxFields) + " fields");
      return false;
    }
    compute_layout(message);
    if (message.max_length > kMaxPayloadBytes) {
      diagnostics_.error(message.position, "message " + message.name + " needs " +
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
    expect_attributes(element, kAttributes);
    for (const auto& child : element.children) {
      if (child.name != "description") expect_child(element, child, {});
    }
    Field field;
    field.position = element.position;
    field.extension = extension;
    field.name = require_name(element);
    const bool typed = parse_type(element, field);
    if (field.name.empty() || !typed) return false;
    if (!names.insert(field.name).second) {
      diagnostics_.error(element.find("name")->position,
                         "message " + message.name + " has the field " + field.name + " twice");
      return false;
    }
    field.enum_name = value_of(element, "enum");
    field.units = value_of(element, "units");
    field.multiplier = value_of(element, "multiplier");
    field.invalid = value_of(element, "invalid");
    field.print_format = value_of(element, "print_format");
    field.default_value = value_of(element, "default");
    field.min_value = value_of(element, "minValue");
    field.max_value = value_of(element, "maxValue");
    field.display_bitmask = value_of(element, "display") == "bitmask";
    field.instance = parse_flag(element, "instance");
    field.text = prose(element.text);
    message.fields.push_back(std::move(field));
    return true;
  }

  /// Reads `type`, `type[n]`, the old `array[n]` and uint8_t_mavlink_version.
  bool parse_type(const Element& element, Field& field) {
    const auto* attribute = require(element, "type");
    if (attribute == nullptr) return false;
    const auto text = trimmed(attribute->value);
    auto base = std::string_view(text);
    if (const auto bracket = base.find('['); bracket != std::string_view::npos) {
      const auto closed = base.back() == ']';
      const auto digits = base.substr(bracket + 1, base.size() - bracket - 2);
      const auto length = closed ? parse_number(digits, kMaxArrayLength) : std::nullopt;
      if (!length || *length == 0) {
        diagnostics_.error(attribute->position,
                           quoted(attribute->value) + " has no array length from 1 to 255");
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
    diagnostics_.error(attribute->position,
                       "unknown type " + quoted(base) + suggestion(base, known));
    return false;
  }

  Diagnostics& diagnostics_;
  ParsedFile file_;
};

}  // namespace

ParsedFile parse_file(const Element& root, Diagnostics& diagnostics) {
  return FileParser(diagnostics).parse(root);
}

}  // namespace cas::mav::xml
