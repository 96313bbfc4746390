// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

namespace cas::base {

/// What separates numbers in the files of other programs.
inline constexpr std::string_view kNumberSpace = " \t\r\n\f\v";

/// The number that a word is from its first to its last character, with a point for the decimals;
/// nullopt for anything else: "0,5", "0.5m", "1-2", a number too large for its type, and, for a
/// floating-point type, "nan" and "inf".
template <class Number>
std::optional<Number> number_of(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  Number value{};
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

/// The first word of a text, which is cut off it; empty when the text is blank.
inline std::string_view next_word(std::string_view& text, std::string_view space = kNumberSpace) {
  const std::size_t first = text.find_first_not_of(space);
  if (first == text.npos) return text = {};
  text.remove_prefix(first);
  const std::string_view word = text.substr(0, text.find_first_of(space));
  text.remove_prefix(word.size());
  return word;
}

/// Appends the numbers of a text, separated by white space, to `values`.
/// @return the first word that is no number_of(), which ends the reading; nullopt: all were read
template <class Number>
std::optional<std::string_view> read_numbers(std::string_view text, std::vector<Number>& values) {
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const std::optional<Number> value = number_of<Number>(word);
    if (!value) return word;
    values.push_back(*value);
  }
  return std::nullopt;
}

/// The end of a sentence about a word that is no number: a hint where it has a comma or a unit.
inline std::string number_hint(std::string_view word) {
  if (word.find(',') != word.npos) return " (decimals follow a point, not a comma)";
  const std::size_t end = word.find_first_not_of("0123456789.+-eE");
  const bool has_unit = end != word.npos && number_of<double>(word.substr(0, end));
  return has_unit ? " (a number alone, without a unit)" : "";
}

/// "'0,5' is no number (decimals follow a point, not a comma)": for errors.
inline std::string no_number(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  return "'" + std::string(word.substr(0, kLongest)) + (word.size() > kLongest ? "..." : "") +
         "' is no number" + number_hint(word);
}

}  // namespace cas::base
