// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace cas::casd {

inline constexpr std::size_t kLongestLinkName = 64;

/// Whether a name is short and has only the characters that a link's may have: letters, digits, and
/// _ - . because it stands in logs, terminals, metrics and names of files. Pure.
inline bool is_link_name(std::string_view name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  return name.size() <= kLongestLinkName && std::ranges::all_of(name, is_plain);
}

}  // namespace cas::casd
