// SPDX-License-Identifier: BSD-3-Clause
#include "base/printable.hpp"

#include <algorithm>
#include <array>

namespace cas::base {
namespace {

/// Characters of two to four bytes of UTF-8 that differ in the last one.
struct Range {
  std::string_view begin;
  unsigned char first;
  unsigned char last;
};

constexpr std::array kHidden{
    Range{"\xC2", 0x80, 0x9F},          // C1
    Range{"\xC2", 0xAD, 0xAD},          // soft hyphen
    Range{"\xD8", 0x9C, 0x9C},          // Arabic letter mark
    Range{"\xE1\xA0", 0x8E, 0x8E},      // Mongolian vowel separator
    Range{"\xE2\x80", 0x8B, 0x8F},      // zero width, left-to-right mark
    Range{"\xE2\x80", 0xA8, 0xAE},      // line separators, embeddings, overrides
    Range{"\xE2\x81", 0xA0, 0xAF},      // word joiner, isolates
    Range{"\xEF\xBB", 0xBF, 0xBF},      // byte order mark
    Range{"\xF3\xA0\x80", 0x80, 0xBF},  // tags, to U+E003F
    Range{"\xF3\xA0\x81", 0x80, 0xBF},  // tags, to U+E007F
};

/// Bytes of the character that `text` begins with, if it is a hidden one; else 0.
std::size_t hidden_bytes(std::string_view text) {
  const auto byte = static_cast<unsigned char>(text.front());
  if ((byte < 0x20 && byte != '\t') || byte == 0x7F) return 1;
  const auto found = std::ranges::find_if(kHidden, [text](const Range& range) {
    const std::size_t size = range.begin.size();
    if (!text.starts_with(range.begin) || text.size() == size) return false;
    const auto last = static_cast<unsigned char>(text[size]);
    return last >= range.first && last <= range.last;
  });
  return found == kHidden.end() ? 0 : found->begin.size() + 1;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string clean;
  clean.reserve(text.size());
  while (!text.empty()) {
    const std::size_t hidden = hidden_bytes(text);
    clean += hidden > 0 ? '?' : text.front();
    text.remove_prefix(std::max<std::size_t>(hidden, 1));
  }
  return clean;
}

std::string printable_lines(std::string_view text) {
  std::string lines;
  for (;;) {
    const std::size_t end = text.find('\n');
    lines += printable(text.substr(0, end));
    if (end == text.npos) return lines;
    lines += '\n';
    text.remove_prefix(end + 1);
  }
}

}  // namespace cas::base
