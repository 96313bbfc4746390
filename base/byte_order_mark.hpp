// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace cas::base {

/// A text in UTF-8 without the three bytes that Windows editors write before it.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

}  // namespace cas::base
