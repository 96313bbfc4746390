// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/config/config_keys.hpp"
#include "base/export.hpp"

namespace cas::base {

/// Lines of a table in Markdown: key, default, values and meaning.
/// @param first  text before each: a column of its own, "restart | "
CAS_BASE_EXPORT std::string key_lines(const std::vector<KeyRow>& rows, std::string_view first = "");

/// A whole table: the lines below their heads.
CAS_BASE_EXPORT std::string key_table(const std::vector<KeyRow>& rows);

/// A whole table of the keys of a list, as a program's --keys prints it and
/// docs/reference/config.md shows it.
/// @param defaults  a struct as it is before it is read
template <class Keys, class Struct>
std::string key_table(const Keys& keys, const Struct& defaults) {
  std::vector<KeyRow> rows;
  add_rows(keys, defaults, rows);
  return key_table(rows);
}

}  // namespace cas::base
