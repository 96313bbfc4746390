// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace cas::casctl {

/// A drawing of dots in characters: 2 x 4 dots a character (braille), so that a dot is as wide as
/// high; without Unicode three marks for upper, lower and both halves. Row 0 is at the top.
class DotCanvas {
 public:
  DotCanvas(std::size_t columns, std::size_t rows)
      : columns_(columns), rows_(rows), cells_(columns * rows, 0) {}

  int width() const { return static_cast<int>(columns_) * 2; }
  int height() const { return static_cast<int>(rows_) * 4; }
  /// Dots beside the canvas are left out.
  void dot(int x, int y);
  void line(int x1, int y1, int x2, int y2);
  /// A character in the place of a dot's whole cell.
  void mark(int x, int y, const std::string& glyph);
  std::vector<std::string> lines(bool unicode) const;

 private:
  std::size_t columns_, rows_;
  std::vector<std::uint8_t> cells_;           ///< bits as in U+2800
  std::map<std::size_t, std::string> marks_;  ///< by cell
};

}  // namespace cas::casctl
