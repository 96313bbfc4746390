// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>

#include "base/printable.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

namespace {

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

std::string list_of(const std::vector<std::string>& sentences, const std::string& bullet) {
  std::string text;
  for (const std::string& sentence : sentences) text += bullet + sentence + "\n";
  return text;
}

/// Blocks on a terminal.
struct TextBlocks {
  std::string text{};

  void operator()(const Document::Verdict& verdict) {
    if (!text.empty()) text += "\n";
    text += verdict.word + ": " + verdict.line + "\n" + list_of(verdict.sentences, "  - ");
  }
  void operator()(const Document::Heading& heading) { text += "\n== " + heading.text + " ==\n"; }
  void operator()(const Document::Paragraph& paragraph) { text += "\n" + paragraph.text + "\n"; }
  void operator()(const Document::Table& table) {
    text += "\n" + table.caption + "\n" + aligned_table(table.rows, table.align);
  }
  void operator()(const auto& /*of_pages*/) {}
};

/// A cell that ends neither its column nor its row.
std::string markdown_cell(const Cell& cell) {
  std::string text = cell.text + (cell.detail.empty() ? "" : "; ") + cell.detail;
  for (std::size_t i = 0; (i = text.find('|', i)) != std::string::npos; i += 2)
    text.insert(i, "\\");
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// Blocks in Markdown.
struct MarkdownBlocks {
  std::string text{};

  void operator()(const Document::Verdict& verdict) {
    text += "**" + verdict.word + "**: " + verdict.line + "\n";
    if (!verdict.sentences.empty()) text += "\n" + list_of(verdict.sentences, "- ");
  }
  void operator()(const Document::Heading& heading) { text += "\n## " + heading.text + "\n"; }
  void operator()(const Document::Paragraph& paragraph) { text += "\n" + paragraph.text + "\n"; }
  void operator()(const Document::Table& table) {
    text += "\n" + table.caption + "\n\n";
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      text += "|";
      for (const Cell& cell : table.rows[r]) text += " " + markdown_cell(cell) + " |";
      text += "\n";
      if (r > 0) continue;
      text += "|";
      for (std::size_t i = 0; i < table.rows[r].size(); ++i) {
        text += i > 0 && table.align == Align::kRight ? "---:|" : "---|";
      }
      text += "\n";
    }
  }
  void operator()(const auto& /*of_pages*/) {}
};

/// The sections that are not of pages alone.
template <class Blocks>
std::string written(const Document& document, Blocks writer) {
  bool shown = true;
  for (const Document::Block& block : document.blocks) {
    if (const auto* heading = std::get_if<Document::Heading>(&block)) {
      shown = heading->extent == Extent::kEverywhere;
    }
    if (shown) std::visit(writer, block);
  }
  return std::move(writer.text);
}

}  // namespace

std::string aligned_table(const Rows& rows, Align align) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], width_of(row[i].text));
    }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string room(widths[i] - width_of(row[i].text), ' ');
      const bool right = i > 0 && align == Align::kRight;
      line += (i == 0 ? "" : "  ") + (right ? room + row[i].text : row[i].text + room);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return base::printable_lines(text);
}

std::string write_text(const Document& document) {
  return base::printable_lines(written(document, TextBlocks{}));
}

std::string write_markdown(const Document& document) {
  return written(document, MarkdownBlocks{"# " + document.title + "\n\n"});
}

}  // namespace cas::hils
