// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/file_parser.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "mavlink_gen/parser/numbers.hpp"

namespace cas::mav::xml {
namespace {

constexpr int kMaxParams = 7;

class EnumParser final {
 public:
  explicit EnumParser(ElementReader& reader) : reader_(reader) {}

  std::optional<Enum> parse(const Element& element) {
    constexpr std::array<std::string_view, 2> kAttributes{"name", "bitmask"};
    constexpr std::array<std::string_view, 5> kChildren{"description", "wip", "superseded",
                                                        "deprecated", "entry"};
    reader_.expect_attributes(element, kAttributes);
    Enum result;
    result.position = element.position;
    result.name = reader_.require_name(element);
    result.bitmask = reader_.parse_flag(element, "bitmask");
    std::optional<EnumValue> highest;
    for (const auto& child : element.children) {
      if (!reader_.expect_child(element, child, kChildren)) continue;
      if (reader_.parse_common_child(child, result.text, result.lifecycle)) continue;
      if (auto entry = parse_entry(child, highest)) {
        if (!highest || highest->less(entry->value)) highest = entry->value;
        result.entries.push_back(std::move(*entry));
      }
    }
    if (result.name.empty()) return std::nullopt;
    return result;
  }

 private:
  std::optional<Entry> parse_entry(const Element& element, std::optional<EnumValue> highest) {
    constexpr std::array<std::string_view, 5> kAttributes{"value", "name", "hasLocation",
                                                          "isDestination", "missionOnly"};
    constexpr std::array<std::string_view, 5> kChildren{"description", "wip", "superseded",
                                                        "deprecated", "param"};
    reader_.expect_attributes(element, kAttributes);
    Entry entry;
    entry.position = element.position;
    entry.name = reader_.require_name(element);
    entry.has_location = reader_.parse_flag(element, "hasLocation");
    entry.is_destination = reader_.parse_flag(element, "isDestination");
    entry.mission_only = reader_.parse_flag(element, "missionOnly");
    for (const auto& child : element.children) {
      if (!reader_.expect_child(element, child, kChildren)) continue;
      if (!reader_.parse_common_child(child, entry.text, entry.lifecycle))
        parse_param(child, entry);
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
      reader_.error(element.position, "the entry needs a value: none is left above the highest");
      return std::nullopt;
    }
    const auto value = parse_enum_value(trimmed(attribute->value));
    if (!value) {
      reader_.error(attribute->position,
                    in_quotes(attribute->value) +
                        " is no enum value: decimal, 0x, 0b or 2**n, at most 64 bit");
    }
    return value;
  }

  void parse_param(const Element& element, Entry& entry) {
    constexpr std::array<std::string_view, 9> kAttributes{"index",     "label",    "units",
                                                          "enum",      "minValue", "maxValue",
                                                          "increment", "default",  "reserved"};
    reader_.expect_attributes(element, kAttributes);
    const auto* index = reader_.require(element, "index");
    if (index == nullptr) return;
    const auto number = parse_number(trimmed(index->value), kMaxParams);
    if (!number || *number == 0) {
      reader_.error(index->position, in_quotes(index->value) + " is no parameter index: 1 to 7");
      return;
    }
    Param param;
    param.index = static_cast<int>(*number);
    const auto twice = std::any_of(entry.params.begin(), entry.params.end(),
                                   [&](const Param& p) { return p.index == param.index; });
    if (twice) {
      reader_.error(index->position, "parameter " + std::to_string(param.index) + " stands twice");
      return;
    }
    param.label = ElementReader::value_of(element, "label");
    param.units = ElementReader::value_of(element, "units");
    param.enum_name = ElementReader::value_of(element, "enum");
    param.min_value = ElementReader::value_of(element, "minValue");
    param.max_value = ElementReader::value_of(element, "maxValue");
    param.increment = ElementReader::value_of(element, "increment");
    param.default_value = ElementReader::value_of(element, "default");
    param.reserved = reader_.parse_flag(element, "reserved");
    param.text = prose(element.text);
    entry.params.push_back(std::move(param));
  }

  ElementReader& reader_;
};

}  // namespace

std::optional<Enum> parse_enum(const Element& element, ElementReader& reader) {
  return EnumParser(reader).parse(element);
}

}  // namespace cas::mav::xml
