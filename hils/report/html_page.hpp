// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace cas::hils {

/// Builds one self-contained HTML file for screen and paper: no script, no other file.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);

  enum class Mood { kGood, kBad, kNeutral };
  /// The verdict on top: a word, a line below it and the sentences.
  void verdict(Mood mood, const std::string& word, const std::string& line,
               const std::vector<std::string>& sentences);
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// First row: headings. Cells of the first column are names, all others figures. Rows of
  /// `quiet_rows` (by index below the headings) are set back, such as those of a reference.
  void table(const std::string& caption, const std::vector<std::vector<std::string>>& rows,
             const std::vector<std::size_t>& quiet_rows = {});
  /// An SVG element.
  void figure(const std::string& svg);
  /// A text that is shown on demand: a configuration file.
  void folded(const std::string& summary, const std::string& text);

  std::string finish() const;

 private:
  std::string body_;
  std::string title_;
};

}  // namespace cas::hils
