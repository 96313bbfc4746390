// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hils/report/plot.hpp"

namespace cas::hils {

/// Builds one self-contained HTML file for screen and paper, which needs no other file and reads
/// without a script: with one its plots can be zoomed (plot_data.hpp). Dark where the reader
/// prefers it, and readable from 500 pixels of width.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);

  enum class Mood { kGood, kBad, kNeutral };
  /// The verdict on top: a word, a line below it and the sentences.
  void verdict(Mood mood, const std::string& word, const std::string& line,
               const std::vector<std::string>& sentences);
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// How a row of a table looks.
  enum class Row {
    kPlain,
    kQuiet,   ///< set back: of a reference
    kMissed,  ///< in red
  };
  /// First row: headings. Cells of the first column are names, all others figures. A table that is
  /// wider than the page scrolls inside its own box.
  ///
  /// @param looks  of the rows below the headings; those beyond its end are plain
  void table(const std::string& caption, const std::vector<std::vector<std::string>>& rows,
             const std::vector<Row>& looks = {});
  /// A cell of a matrix: its text, the reason below it in small letters, and its link.
  struct Cell {
    std::string text{};
    std::string detail{};
    std::string address{};  ///< empty: nowhere
    std::optional<Mood> mood{};
  };
  /// A table whose cells have colours and links; the first of each row is its name.
  void matrix(const std::string& caption, const std::vector<std::string>& headings,
              const std::vector<std::vector<Cell>>& rows);
  /// A list of links, each an address and its text.
  void links(const std::vector<std::pair<std::string, std::string>>& list);
  /// A drawing that stays one: an SVG element.
  void figure(const std::string& svg);
  void plot(const Plot& plot);
  /// A text that is shown on demand: a configuration file.
  void folded(const std::string& summary, const std::string& text);

  std::string finish() const;

 private:
  std::string body_;
  std::string title_;
};

}  // namespace cas::hils
