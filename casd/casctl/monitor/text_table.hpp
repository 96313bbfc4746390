// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// A column of a table on the screen.
struct TextColumn {
  std::string header;
  int rank = 0;        ///< where the table is too wide, the highest is left out first, as a whole
  bool right = false;  ///< to the right: numbers
};

struct TextRow {
  std::vector<std::string> cells;  ///< of all columns
  Style style = Style::kPlain;
};

/// Lays out a table: each column as wide as its widest cell, so that no cell is ever cut; columns
/// that have no room are left out, and room that is left goes between the columns.
class TextTable {
 public:
  TextTable(std::vector<TextColumn> columns, std::vector<TextRow> rows, std::size_t width);

  ScreenLine header() const;
  ScreenLine row(std::size_t index) const;
  /// The header, and the rows from `first` on that have room in `most` lines.
  Block lines(std::size_t first, std::size_t most) const;
  /// The same, scrolled as far as the selected row needs.
  Block scrolled(std::size_t selected, std::size_t most) const;
  std::size_t size() const { return rows_.size(); }
  /// Whether a column is on the screen.
  bool shows(const std::string& header) const;

 private:
  std::string text(const std::vector<std::string>& cells) const;

  std::vector<TextColumn> columns_;
  std::vector<TextRow> rows_;
  std::vector<std::size_t> widths_;
  std::vector<std::size_t> shown_;
  std::size_t gap_ = 1;
};

}  // namespace cas::casctl
