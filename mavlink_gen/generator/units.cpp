// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/units.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "mavlink_gen/parser/numbers.hpp"

namespace cas::mav::gen {
namespace {

struct UnitFacts {
  std::string_view wire, plain, factor, divisor;
};

// clang-format off
constexpr std::array kUnits = std::to_array<UnitFacts>({
    {"degE7", "deg", "1", "1e7"},      {"degE5", "deg", "1", "1e5"},    {"cdeg", "deg", "1", "100"},
    {"ddeg/s", "deg_s", "1", "10"},    {"mrad/s", "rad_s", "1", "1000"}, {"mm", "m", "1", "1000"},
    {"cm", "m", "1", "100"},           {"dm", "m", "1", "10"},          {"dam", "m", "10", "1"},
    {"mm/s", "m_s", "1", "1000"},      {"cm/s", "m_s", "1", "100"},     {"dm/s", "m_s", "1", "10"},
    {"cm^2", "m2", "1", "1e4"},        {"mV", "v", "1", "1000"},        {"cV", "v", "1", "100"},
    {"mA", "a", "1", "1000"},          {"cA", "a", "1", "100"},         {"mAh", "ah", "1", "1000"},
    {"hJ", "j", "100", "1"},           {"cdegC", "degc", "1", "100"},   {"c%", "percent", "1", "100"},
    {"d%", "percent", "1", "10"},      {"mgauss", "gauss", "1", "1000"}, {"hPa", "pa", "100", "1"},
    {"kPa", "pa", "1000", "1"},        {"mbar", "pa", "100", "1"},
    {"cs", "s", "1", "100"},           {"ds", "s", "1", "10"},          {"ms", "s", "1", "1000"},
    {"us", "s", "1", "1e6"},           {"ns", "s", "1", "1e9"},         {"m/s*5", "m_s", "1", "5"},
    {"deg/2", "deg", "2", "1"},        {"MHz", "hz", "1e6", "1"},       {"cm^3", "m3", "1", "1e6"},
    // standard gravity, by definition 9.80665 m/s^2
    {"mG", "m_s2", "9.80665", "1000"},
});
// clang-format on

/// A number of the XML as a C++ literal of type double.
std::optional<std::string> double_literal(std::string_view text) {
  double value{};
  const auto* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  std::array<char, 32> digits;
  const auto [last, status] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  static_cast<void>(status);
  return std::string(digits.data(), last);
}

/// A limit of an integer type by its name: UINT16_MAX ...
std::optional<xml::EnumValue> limit(std::string_view text) {
  const bool is_max = text.ends_with("_MAX");
  if (!is_max && !text.ends_with("_MIN")) return std::nullopt;
  text.remove_suffix(4);
  const bool is_unsigned = text.starts_with("UINT");
  if (!is_unsigned && !text.starts_with("INT")) return std::nullopt;
  text.remove_prefix(is_unsigned ? 4 : 3);
  const auto bits = xml::parse_number(text, 64);
  if (!bits || (*bits != 8 && *bits != 16 && *bits != 32 && *bits != 64)) return std::nullopt;
  if (is_unsigned) {
    return is_max ? xml::EnumValue{~std::uint64_t{0} >> (64U - *bits), false} : xml::EnumValue{};
  }
  const auto top = std::uint64_t{1} << (*bits - 1U);
  return is_max ? xml::EnumValue{top - 1, false} : xml::EnumValue{~top + 1, true};
}

std::string integer_literal(const xml::EnumValue& value) {
  constexpr std::uint64_t kLowest = std::uint64_t{1} << 63U;
  if (value.negative && value.bits == kLowest) return "INT64_MIN";
  auto text = value.decimal();
  if (!value.negative && value.bits > 0x7FFFFFFFU) text += value.bits >= kLowest ? "ULL" : "LL";
  if (value.negative && ~value.bits >= 0x7FFFFFFFU) text += "LL";
  return text;
}

std::optional<xml::EnumValue> integer_of(std::string_view text, const xml::Field& field,
                                         const xml::Dialect& dialect) {
  if (const auto value = limit(text)) return value;
  if (const auto value = xml::parse_enum_value(text)) return value;
  const auto* item = dialect.find_enum(field.enum_name);
  if (item == nullptr) return std::nullopt;
  const auto entry = std::find_if(item->entries.begin(), item->entries.end(),
                                  [&](const xml::Entry& e) { return e.name == text; });
  return entry == item->entries.end() ? std::nullopt : std::optional(entry->value);
}

}  // namespace

std::optional<Scale> scale_of(const xml::Field& field) {
  if (field.array_length != 0 || field.type == xml::BaseType::kChar || !field.enum_name.empty()) {
    return std::nullopt;
  }
  if (!field.multiplier.empty()) {
    const auto factor = double_literal(field.multiplier);
    // 1E-2 is no binary fraction; to divide by 100 is exact where the result is.
    if (field.multiplier == "1E-2" || field.multiplier == "0.01")
      return Scale{"scaled", "1", "100"};
    return factor ? std::optional(Scale{"scaled", *factor, "1"}) : std::nullopt;
  }
  const auto facts = std::find_if(kUnits.begin(), kUnits.end(),
                                  [&](const UnitFacts& unit) { return unit.wire == field.units; });
  if (facts == kUnits.end()) return std::nullopt;
  return Scale{facts->plain, std::string(facts->factor), std::string(facts->divisor)};
}

std::optional<Sentinel> sentinel_of(const xml::Field& field, const xml::Dialect& dialect) {
  auto text = std::string_view(field.invalid);
  if (text.empty() || field.type == xml::BaseType::kChar) return std::nullopt;
  Sentinel sentinel;
  if (text.front() == '[' && text.back() == ']' && text.size() > 2) {
    text = text.substr(1, text.size() - 2);
    sentinel.extent = Sentinel::Extent::kFirstElement;
    if (text.back() == ':') sentinel.extent = Sentinel::Extent::kAllElements;
    if (text.back() == ':' || text.back() == ',') text.remove_suffix(1);
  } else if (field.array_length != 0) {
    sentinel.extent = Sentinel::Extent::kAllElements;
  }
  if (sentinel.extent != Sentinel::Extent::kScalar && field.array_length == 0) return std::nullopt;
  if (xml::is_integer(field.type)) {
    const auto value = integer_of(text, field, dialect);
    if (!value || !xml::holds(field.type, *value)) return std::nullopt;
    sentinel.literal = integer_literal(*value);
    return sentinel;
  }
  sentinel.is_nan = text == "NaN" || text == "NAN" || text == "nan";
  if (sentinel.is_nan) return sentinel;
  if (const auto value = limit(text)) {
    sentinel.literal = integer_literal(*value);
  } else if (const auto number = double_literal(text)) {
    sentinel.literal = *number;
  } else {
    return std::nullopt;
  }
  return sentinel;
}

}  // namespace cas::mav::gen
