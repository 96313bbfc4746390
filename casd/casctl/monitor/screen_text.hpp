// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace cas::casctl {

/// How text is drawn; without colours the styles fall back to plain, bold, dim and reverse.
enum class Style { kPlain, kTitle, kAlarm, kHeader, kSelected, kGood, kBad, kDim };

struct Span {
  std::string text;  ///< UTF-8
  Style style = Style::kPlain;
};

/// One line of the screen, from left to right.
struct ScreenLine {
  ScreenLine() = default;
  ScreenLine(std::string text, Style style = Style::kPlain) : spans{{std::move(text), style}} {}

  ScreenLine& add(std::string text, Style style = Style::kPlain);
  ScreenLine& add(const ScreenLine& more);
  std::string text() const;

  std::vector<Span> spans;
};

/// Lines that belong together: a table, a plot, a pane.
using Block = std::vector<ScreenLine>;

/// A piece of a line that is left out as a whole where it has no room.
struct Segment {
  std::string text;
  Style style = Style::kPlain;
  int rank = 0;  ///< the highest goes first
};

/// Columns that a text takes on a terminal (one per character).
std::size_t columns(const std::string& text);
std::size_t columns(const ScreenLine& line);
/// Pads to this many columns.
std::string left(const std::string& text, std::size_t width);
std::string right(const std::string& text, std::size_t width);
/// The whole words that have room.
std::string fit_words(const std::string& text, std::size_t width);
/// Breaks at spaces; only a word that is longer than the line is broken itself.
std::vector<std::string> wrap(const std::string& text, std::size_t width);
/// As wrap(), as lines of one style that begin with `indent`.
Block wrapped(const std::string& text, std::size_t width, Style style,
              const std::string& indent = "");
/// The segments that have room together, with `gap` columns between them.
ScreenLine join(const std::vector<Segment>& segments, std::size_t width, std::size_t gap = 2);
/// As wide as `width`: padded in `padding`, or without the words that have no room.
ScreenLine fit_line(const ScreenLine& line, std::size_t width, Style padding = Style::kPlain);
/// Exactly this large.
Block fit_block(Block block, std::size_t rows, std::size_t width);
/// Two blocks of equal height side by side.
Block beside(const Block& first, const std::string& separator, const Block& second);
void append(Block& to, const Block& more);

}  // namespace cas::casctl
