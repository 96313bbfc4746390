// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

#include "mavlink_gen/runtime/message.hpp"

namespace cas::mav {

/// Whether two field values are the same; NaN is the same as NaN.
template <class T>
constexpr bool same_value(const T& a, const T& b) {
  if constexpr (std::is_floating_point_v<T>) {
    if (is_nan(a) && is_nan(b)) return true;
  }
  return a == b;
}

/// Likewise, element by element.
template <class T, std::size_t n>
constexpr bool same_value(const std::array<T, n>& a, const std::array<T, n>& b) {
  for (std::size_t i = 0; i < n; ++i) {
    if (!same_value(a[i], b[i])) return false;
  }
  return true;
}

/// Calls visitor(const FieldInfo&, a's value, b's value) for each field in which a and b differ.
/// @return how many there are
template <class Message, class Visitor>
std::size_t for_each_difference(const Message& a, const Message& b, Visitor&& visitor) {
  std::size_t count = 0;
  Message::for_each_field(
      [&](const FieldInfo& field, const auto& left, const auto& right) {
        if (same_value(left, right)) return;
        ++count;
        visitor(field, left, right);
      },
      a, b);
  return count;
}

}  // namespace cas::mav
