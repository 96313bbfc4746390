// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/printable.hpp"

#include <algorithm>
#include <cstddef>

#include "base/printable.hpp"

namespace cas::casctl {

std::string printable(std::string text) {
  std::ranges::replace(text, '\t', '?');
  return base::printable(text);
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
