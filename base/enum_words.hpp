// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace cas::base {

/// The words of an enumeration whose enumerators count up from 0 to `kLast`, in their order.
template <auto kLast>
struct EnumWords {
  using Enum = decltype(kLast);
  static constexpr std::size_t kCount = static_cast<std::size_t>(kLast) + 1;

  template <class... Words>
  requires(sizeof...(Words) == kCount) explicit constexpr EnumWords(Words... in_order)
      : words{in_order...} {}

  /// "?" for a value that is no enumerator.
  constexpr std::string_view operator[](Enum value) const {
    const auto index = static_cast<std::size_t>(value);
    return index < kCount ? words[index] : "?";
  }
  constexpr std::optional<Enum> find(std::string_view word) const {
    for (std::size_t i = 0; i < kCount; ++i) {
      if (words[i] == word) return static_cast<Enum>(i);
    }
    return std::nullopt;
  }

  std::array<std::string_view, kCount> words;
};

}  // namespace cas::base
