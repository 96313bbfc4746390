// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/screen_text.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

namespace cas::casctl {
namespace {

bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }

/// Bytes of the first `count` characters.
std::size_t bytes_of(const std::string& text, std::size_t count) {
  std::size_t taken = 0;
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    if (begins_character(text[end]) && taken++ == count) break;
  }
  return end;
}

}  // namespace

ScreenLine& ScreenLine::add(std::string text, Style style) {
  spans.push_back({std::move(text), style});
  return *this;
}

ScreenLine& ScreenLine::add(const ScreenLine& more) {
  spans.insert(spans.end(), more.spans.begin(), more.spans.end());
  return *this;
}

std::string ScreenLine::text() const {
  std::string all;
  for (const Span& span : spans) all += span.text;
  return all;
}

std::size_t columns(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_character));
}

std::size_t columns(const ScreenLine& line) {
  std::size_t sum = 0;
  for (const Span& span : line.spans) sum += columns(span.text);
  return sum;
}

std::string left(const std::string& text, std::size_t width) {
  const std::size_t taken = columns(text);
  return taken >= width ? text : text + std::string(width - taken, ' ');
}

std::string right(const std::string& text, std::size_t width) {
  const std::size_t taken = columns(text);
  return taken >= width ? text : std::string(width - taken, ' ') + text;
}

std::string fit_words(const std::string& text, std::size_t width) {
  if (columns(text) <= width) return text;
  std::size_t end = bytes_of(text, width);
  if (text[end] != ' ') {
    const std::size_t space = end == 0 ? std::string::npos : text.rfind(' ', end - 1);
    end = space == std::string::npos ? 0 : space;
  }
  return text.substr(0, end);
}

std::vector<std::string> wrap(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  if (width == 0) return lines;
  std::istringstream words(text);
  std::string line;
  for (std::string word; words >> word;) {
    if (!line.empty() && columns(line) + 1 + columns(word) > width) {
      lines.push_back(std::exchange(line, ""));
    }
    for (; columns(word) > width; word.erase(0, bytes_of(word, width))) {
      lines.push_back(word.substr(0, bytes_of(word, width)));
    }
    line += (line.empty() ? "" : " ") + word;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

Block wrapped(const std::string& text, std::size_t width, Style style, const std::string& indent) {
  Block block;
  const std::size_t room = width - std::min(width, columns(indent));
  for (const std::string& line : wrap(text, room)) block.emplace_back(indent + line, style);
  return block;
}

ScreenLine join(const std::vector<Segment>& segments, std::size_t width, std::size_t gap) {
  std::vector<const Segment*> kept;
  for (const Segment& segment : segments) {
    if (!segment.text.empty()) kept.push_back(&segment);
  }
  const auto needed = [&] {
    std::size_t sum = 0;
    for (const Segment* segment : kept) sum += columns(segment->text) + (sum > 0 ? gap : 0);
    return sum;
  };
  while (!kept.empty() && needed() > width) {
    kept.erase(std::max_element(kept.begin(), kept.end(), [](const Segment* a, const Segment* b) {
      return a->rank < b->rank;
    }));
  }
  ScreenLine line;
  for (const Segment* segment : kept) {
    if (!line.spans.empty()) {
      const bool is_header = line.spans.back().style == Style::kHeader;
      line.add(std::string(gap, ' '), is_header ? Style::kHeader : Style::kPlain);
    }
    line.add(segment->text, segment->style);
  }
  return line;
}

ScreenLine fit_line(const ScreenLine& line, std::size_t width, Style padding) {
  ScreenLine fitted;
  std::size_t room = width;
  for (const Span& span : line.spans) {
    const std::string text = fit_words(span.text, room);
    fitted.add(text, span.style);
    room -= columns(text);
    if (text.size() < span.text.size()) break;
  }
  if (room > 0) fitted.add(std::string(room, ' '), padding);
  return fitted;
}

Block fit_block(Block block, std::size_t rows, std::size_t width) {
  block.resize(rows);
  for (ScreenLine& line : block) {
    // Headers and selections go on to the pane's edge.
    const Style last = line.spans.empty() ? Style::kPlain : line.spans.back().style;
    const bool goes_on = last == Style::kHeader || last == Style::kSelected;
    line = fit_line(line, width, goes_on ? last : Style::kPlain);
  }
  return block;
}

Block beside(const Block& first, const std::string& separator, const Block& second) {
  Block both = first;
  for (std::size_t i = 0; i < both.size() && i < second.size(); ++i) {
    both[i].add(separator, Style::kDim).add(second[i]);
  }
  return both;
}

void append(Block& to, const Block& more) { to.insert(to.end(), more.begin(), more.end()); }

}  // namespace cas::casctl
