// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/printable.hpp"

#include <cstddef>

namespace cas::casctl {

std::string printable(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x20 || byte == 0x7F) text[i] = '?';
    // U+0080 to U+009F
    if (byte == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0) {
      text.replace(i, 2, "?");
    }
  }
  return text;
}

std::string printable_lines(const std::string& text) {
  std::string lines;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find('\n', begin);
    lines += printable(text.substr(begin, end - begin));
    if (end == std::string::npos) return lines;
    lines += '\n';
    begin = end + 1;
  }
}

}  // namespace cas::casctl
