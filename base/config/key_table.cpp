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

std::string key_table(const std::vector<KeyRow>& rows) {
  return "| key | default | values | meaning |\n|---|---|---|---|\n" + key_lines(rows);
}

}  // namespace cas::base
