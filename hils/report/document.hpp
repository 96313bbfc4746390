// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "hils/report/plot.hpp"

namespace cas::hils {

enum class Mood { kGood, kBad, kNeutral };

/// A cell of a table. Terminals show its text alone, Markdown the detail behind it.
struct Cell {
  Cell(std::string words = {}) : text(std::move(words)) {}  // NOLINT(google-explicit-constructor)
  Cell(const char* words) : text(words) {}                  // NOLINT(google-explicit-constructor)
  bool operator==(const Cell&) const = default;

  std::string text;
  std::string detail{};        ///< in small letters below the text
  std::string address{};       ///< of its link; empty: none
  std::optional<Mood> mood{};  ///< its colour
  /// From 0 to 1: its colour, from orange by grey to blue, which the colour-blind see, too.
  std::optional<double> share{};
  bool framed = false;
};
using Row = std::vector<Cell>;
/// Rows of a table; headings first.
using Rows = std::vector<Row>;

/// Where cells stand in the columns behind the first one, which is left-aligned.
enum class Align { kLeft, kRight };

/// How a row of a table looks on a page.
enum class Look {
  kPlain,
  kQuiet,   ///< set back: of a reference
  kMissed,  ///< in red
};

/// Where a section is written.
enum class Extent { kEverywhere, kPage };

/// A report: what it says, in order. The writers below decide how that looks on a terminal, in
/// Markdown and on a page.
struct Document {
  /// A word, a line behind it and sentences.
  struct Verdict {
    Mood mood = Mood::kNeutral;
    std::string word;
    std::string line;
    std::vector<std::string> sentences{};
  };
  /// Begins a section.
  struct Heading {
    std::string text;
    Extent extent = Extent::kEverywhere;
  };
  struct Paragraph {
    std::string text;
  };
  struct Table {
    std::string caption;
    Rows rows;
    std::vector<Look> looks{};  ///< of the rows below the headings; those beyond its end are plain
    Align align = Align::kRight;
  };
  /// Addresses and their texts.
  struct Links {
    std::vector<std::pair<std::string, std::string>> list;
  };
  /// A text that is shown on demand: a configuration file.
  struct Folded {
    std::string summary;
    std::string text;
  };
  using Block = std::variant<Verdict, Heading, Paragraph, Table, Plot, Links, Folded>;

  std::string title;
  std::vector<Block> blocks{};

  void add(Block block) { blocks.push_back(std::move(block)); }
  void heading(std::string text, Extent extent = Extent::kEverywhere) {
    add(Heading{std::move(text), extent});
  }
  void paragraph(std::string text) { add(Paragraph{std::move(text)}); }
  void table(std::string caption, Rows rows, std::vector<Look> looks = {},
             Align align = Align::kRight) {
    add(Table{std::move(caption), std::move(rows), std::move(looks), align});
  }
};

/// A table for a terminal: columns as wide as their longest cell, two spaces apart. Widths are
/// counted in characters of UTF-8. Texts of files give a terminal no orders
/// (base::printable_lines).
std::string aligned_table(const Rows& rows, Align align);

/// For a terminal, as aligned_table(); the verdict names the subject; no title. Plots, links
/// and folded texts are of pages alone, as are sections of Extent::kPage.
std::string write_text(const Document& document);

/// The same parts in Markdown.
std::string write_markdown(const Document& document);

/// One self-contained HTML file for screen and paper, which needs no other file and reads without a
/// script: with one its plots can be zoomed (plot_data.hpp). Dark where the reader prefers it, and
/// readable from 500 pixels of width; a wider table scrolls inside its own box. This is the only
/// place where text becomes HTML, escaped.
std::string write_html(const Document& document);

}  // namespace cas::hils
