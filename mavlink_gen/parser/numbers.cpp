// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/numbers.hpp"

#include <charconv>

namespace cas::mav::xml {
namespace {

std::optional<std::uint64_t> parse_unsigned(std::string_view text, int base) {
  std::uint64_t value{};
  const auto* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value, base);
  if (error != std::errc() || stop != end || text.empty()) return std::nullopt;
  return value;
}

bool starts_with_prefix(std::string_view text, char letter) {
  return text.size() > 2 && text[0] == '0' && (text[1] == letter || text[1] == letter - 32);
}

std::optional<std::uint64_t> parse_magnitude(std::string_view text) {
  if (starts_with_prefix(text, 'x')) return parse_unsigned(text.substr(2), 16);
  if (starts_with_prefix(text, 'b')) return parse_unsigned(text.substr(2), 2);
  const auto power = text.find("**");
  if (power == std::string_view::npos) return parse_unsigned(text, 10);
  if (text.substr(0, power) != "2") return std::nullopt;
  const auto exponent = parse_unsigned(text.substr(power + 2), 10);
  if (!exponent || *exponent > 63) return std::nullopt;
  return std::uint64_t{1} << *exponent;
}

}  // namespace

std::optional<EnumValue> parse_enum_value(std::string_view text) {
  constexpr auto kLowestMagnitude = std::uint64_t{1} << 63U;
  const bool minus = !text.empty() && text.front() == '-';
  if (!text.empty() && (minus || text.front() == '+')) text.remove_prefix(1);
  const auto magnitude = parse_magnitude(text);
  if (!magnitude || (minus && *magnitude > kLowestMagnitude)) return std::nullopt;
  if (!minus) return EnumValue{*magnitude, false};
  return EnumValue{~*magnitude + 1, *magnitude != 0};
}

std::optional<std::uint32_t> parse_number(std::string_view text, std::uint32_t max) {
  const auto value = parse_unsigned(text, 10);
  if (!value || *value > max) return std::nullopt;
  return static_cast<std::uint32_t>(*value);
}

}  // namespace cas::mav::xml
