// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>

namespace cas::base {

/// The elements of a list in one text.
/// @param text  of an element: a string, string view or character array
template <class List, class Text = std::identity>
std::string joined(const List& list, std::string_view separator, const Text& text = {}) {
  std::string all;
  bool first = true;
  for (const auto& each : list) {
    if (!first) all += separator;
    first = false;
    all += std::invoke(text, each);
  }
  return all;
}

/// With small letters; ASCII.
inline std::string lower(std::string_view text) {
  std::string small(text);
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return small;
}

/// With capital letters; ASCII.
inline std::string upper(std::string_view text) {
  std::string capitals(text);
  for (char& c : capitals) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return capitals;
}

/// Without blanks at its ends.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

/// Whether a text is one digit or more, and nothing else.
inline bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == text.npos;
}

}  // namespace cas::base
