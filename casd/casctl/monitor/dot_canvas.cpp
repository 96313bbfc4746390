// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/dot_canvas.hpp"

#include <algorithm>
#include <cstdlib>

namespace cas::casctl {
namespace {

/// Bits of a braille character, by row and column of its dots.
constexpr std::uint8_t kBits[4][2] = {{0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}};
constexpr std::uint8_t kUpperHalf = 0x01 | 0x08 | 0x02 | 0x10;

/// UTF-8 of U+2800 + bits.
std::string braille(std::uint8_t bits) {
  return {static_cast<char>(0xE2), static_cast<char>(0xA0 + (bits >> 6)),
          static_cast<char>(0x80 + (bits & 0x3F))};
}

std::string ascii(std::uint8_t bits) {
  const bool upper = (bits & kUpperHalf) != 0;
  const bool lower = (bits & static_cast<std::uint8_t>(~kUpperHalf)) != 0;
  if (upper && lower) return ":";
  return upper ? "'" : ".";
}

}  // namespace

void DotCanvas::dot(int x, int y) {
  if (x < 0 || y < 0 || x >= width() || y >= height()) return;
  cells_[static_cast<std::size_t>(y / 4) * columns_ + static_cast<std::size_t>(x / 2)] |=
      kBits[y % 4][x % 2];
}

void DotCanvas::line(int x1, int y1, int x2, int y2) {
  const int steps = std::max({std::abs(x2 - x1), std::abs(y2 - y1), 1});
  for (int i = 0; i <= steps; ++i) {
    dot(x1 + (x2 - x1) * i / steps, y1 + (y2 - y1) * i / steps);
  }
}

void DotCanvas::mark(int x, int y, const std::string& glyph) {
  if (x < 0 || y < 0 || x >= width() || y >= height()) return;
  marks_[static_cast<std::size_t>(y / 4) * columns_ + static_cast<std::size_t>(x / 2)] = glyph;
}

std::vector<std::string> DotCanvas::lines(bool unicode) const {
  std::vector<std::string> lines(rows_);
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    std::string& line = lines[cell / columns_];
    const auto mark = marks_.find(cell);
    if (mark != marks_.end()) {
      line += mark->second;
    } else if (cells_[cell] == 0) {
      line += ' ';
    } else {
      line += unicode ? braille(cells_[cell]) : ascii(cells_[cell]);
    }
  }
  return lines;
}

}  // namespace cas::casctl
