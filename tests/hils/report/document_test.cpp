// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/document.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

TEST(AlignedTable, NumbersStandOnTheRightAndWordsOnTheLeft) {
  const Rows rows{{"Name", "Hz", "by"}, {"TCAS at 921600", "5.0", "a"}, {"TS", "352.9", "bcd"}};
  EXPECT_EQ(aligned_table(rows, Align::kRight),
            "Name               Hz   by\n"
            "TCAS at 921600    5.0    a\n"
            "TS              352.9  bcd\n");
  EXPECT_EQ(aligned_table(rows, Align::kLeft),
            "Name            Hz     by\n"
            "TCAS at 921600  5.0    a\n"
            "TS              352.9  bcd\n");
}

TEST(AlignedTable, CharactersCountAndNotBytes) {
  EXPECT_EQ(aligned_table({{"", "x"}, {"a", "1 ± 2"}, {"b", "12345"}}, Align::kRight),
            "       x\n"
            "a  1 ± 2\n"
            "b  12345\n");
}

TEST(AlignedTable, RowsMayBeShort) {
  EXPECT_EQ(aligned_table({{"a", "b"}, {"c"}}, Align::kLeft), "a  b\nc\n");
  EXPECT_EQ(aligned_table({}, Align::kLeft), "");
}

TEST(AlignedTable, ATextOfAFileGivesTheTerminalNoOrders) {
  EXPECT_EQ(aligned_table({{"a\x1b[2J", "\xE2\x80\xAE"}, {"c", "d"}}, Align::kLeft),
            "a?[2J  ?\nc      d\n");
  Document document("Report");
  document.add(Document::Verdict{Mood::kBad, "FAILED", "ho\x1b[31m\xC2\x9Bver", {}});
  EXPECT_EQ(write_text(document), "FAILED: ho?[31m?ver\n");
}

/// One of each block, with characters that HTML and Markdown reserve.
Document sample() {
  Document document{"Report <1>"};
  document.add(Document::Verdict{Mood::kBad, "FAILED", "a & b", {"x > 1"}});
  document.heading("Figures");
  document.paragraph("\"Quoted\".");
  Cell missed("1|2");
  missed.detail = "<late>";
  missed.address = "again/row_1/replay.html";
  missed.mood = Mood::kGood;
  document.table("Table & co", {{"Name", "Hz"}, {"TS", missed}}, {Look::kMissed});
  document.table("Words", {{"a", "b"}, {"c", "d"}}, {}, Align::kLeft);
  document.add(Plot{.title = "Curve", .series = {{.name = "s", .points = {{0, 1}, {1, 2}}}}});
  document.heading("Files", Extent::kPage);
  document.paragraph("hidden");
  document.add(Document::Links{{{"a.html?x&y", "the <a>"}}});
  document.add(Document::Folded{"s.yaml", "k: <v>"});
  document.heading("End");
  return document;
}

TEST(Document, IsTextForATerminal) {
  EXPECT_EQ(write_text(sample()),
            "FAILED: a & b\n"
            "  - x > 1\n"
            "\n== Figures ==\n"
            "\n\"Quoted\".\n"
            "\nTable & co\n"
            "Name   Hz\n"
            "TS    1|2\n"
            "\nWords\n"
            "a  b\n"
            "c  d\n"
            "\n== End ==\n");
}

TEST(Document, IsMarkdown) {
  EXPECT_EQ(write_markdown(sample()),
            "# Report <1>\n\n"
            "**FAILED**: a & b\n\n"
            "- x > 1\n"
            "\n## Figures\n"
            "\n\"Quoted\".\n"
            "\nTable & co\n\n"
            "| Name | Hz |\n|---|---:|\n"
            "| TS | 1\\|2; <late> |\n"
            "\nWords\n\n"
            "| a | b |\n|---|---|\n"
            "| c | d |\n"
            "\n## End\n");
}

TEST(Document, IsAPageWithEveryTextEscaped) {
  const std::string html = write_html(sample());
  for (const char* part :
       {"<title>Report &lt;1&gt;</title>", "<h1>Report &lt;1&gt;</h1>",
        "<section class=\"verdict bad\"><strong>FAILED</strong><p>a &amp; b</p>"
        "<ul><li>x &gt; 1</li></ul></section>",
        "<h2>Figures</h2>", "<p>&quot;Quoted&quot;.</p>", "<p class=\"caption\">Table &amp; co</p>",
        "<thead><tr><th>Name</th><th>Hz</th></tr></thead>",
        "<tr class=\"missed\"><td>TS</td><td class=\"good\"><a "
        "href=\"again/row_1/replay.html\">1|2</a><small>&lt;late&gt;</small></td></tr>",
        "<table class=\"words\">", "<figure><svg", "<p>hidden</p>",
        "<ul><li><a href=\"a.html?x&amp;y\">the &lt;a&gt;</a></li></ul>",
        "<details><summary>s.yaml</summary><pre>k: &lt;v&gt;</pre></details>"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part << "\n" << html;
  }
}

}  // namespace
}  // namespace cas::hils
