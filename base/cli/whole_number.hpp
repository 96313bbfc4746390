// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <system_error>

namespace cas::base::cli {

/// For CLI::Option::check() of an unsigned number. CLI11 alone reads -1 as 2^64 - 1, anything above
/// that as well, and 010 as 8.
/// @return an error text; empty if the number is valid
inline std::string whole_number(const std::string& text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  const bool is_whole = result.ec == std::errc() && result.ptr == end;
  const bool is_octal = text.size() > 1 && text.front() == '0';
  if (is_whole && !is_octal) return "";
  return "'" + text + "' is not a whole number, 0 or above, in range";
}

}  // namespace cas::base::cli
