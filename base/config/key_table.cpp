// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/key_table.hpp"

namespace cas::base {

std::string key_lines(const std::vector<KeyRow>& rows, std::string_view first) {
  std::string text;
  for (const KeyRow& row : rows) {
    text.append("| ").append(first).append("`" + row.key + "` | " + row.standard + " | " +
                                           row.values + " | " + row.help + " |\n");
  }
  return text;
}

}  // namespace cas::base
