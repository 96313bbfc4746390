// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/text_table.hpp"

#include <algorithm>
#include <utility>

namespace cas::casctl {
namespace {

constexpr std::size_t kWidestGap = 5;

}  // namespace

TextTable::TextTable(std::vector<TextColumn> columns, std::vector<TextRow> rows, std::size_t width)
    : columns_(std::move(columns)), rows_(std::move(rows)) {
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t widest = casctl::columns(columns_[c].header);
    for (const TextRow& row : rows_) widest = std::max(widest, casctl::columns(row.cells[c]));
    widths_.push_back(widest);
    shown_.push_back(c);
  }
  const auto needed = [this](std::size_t gap) {
    std::size_t sum = 0;
    for (const std::size_t c : shown_) sum += widths_[c] + (sum > 0 ? gap : 0);
    return sum;
  };
  while (shown_.size() > 1 && needed(1) > width) {
    shown_.erase(std::max_element(
        shown_.begin(), shown_.end(),
        [this](std::size_t a, std::size_t b) { return columns_[a].rank < columns_[b].rank; }));
  }
  while (gap_ < kWidestGap && needed(gap_ + 1) <= width) ++gap_;
}

std::string TextTable::text(const std::vector<std::string>& cells) const {
  std::string line;
  for (const std::size_t c : shown_) {
    if (c != shown_.front()) line += std::string(gap_, ' ');
    line += columns_[c].right ? casctl::right(cells[c], widths_[c]) : left(cells[c], widths_[c]);
  }
  return line;
}

ScreenLine TextTable::header() const {
  std::vector<std::string> words;
  for (const TextColumn& column : columns_) words.push_back(column.header);
  return {text(words), Style::kHeader};
}

ScreenLine TextTable::row(std::size_t index) const {
  return {text(rows_[index].cells), rows_[index].style};
}

Block TextTable::lines(std::size_t first, std::size_t most) const {
  Block block{header()};
  for (std::size_t i = first; i < size() && block.size() < most; ++i) block.push_back(row(i));
  return block;
}

Block TextTable::scrolled(std::size_t selected, std::size_t most) const {
  const std::size_t room = most > 1 ? most - 1 : 0;
  return lines(selected < room ? 0 : selected - room + 1, most);
}

bool TextTable::shows(const std::string& header) const {
  return std::any_of(shown_.begin(), shown_.end(),
                     [&](std::size_t c) { return columns_[c].header == header; });
}

}  // namespace cas::casctl
