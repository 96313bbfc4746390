// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "base/enum_words.hpp"
#include "hils/report/document.hpp"
#include "hils/report/plot_data.hpp"

namespace cas::hils {

namespace {

constexpr std::string_view kStyle = R"(
:root{color-scheme:light dark;--ink:#212529;--page:#f1f3f5;--box:#fff;--line:#e9ecef;--head:#e9ecef;
 --quiet:#6c757d;--missed:#c92a2a}
@media screen and (prefers-color-scheme:dark){
 :root{--ink:#dee2e6;--page:#121518;--box:#1c2024;--line:#343a40;--head:#2b3035;--quiet:#909aa3;
  --missed:#ff8787}
}
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--page);margin:0}
main{max-width:76rem;margin:0 auto;padding:1.5rem 1rem 4rem}
h1{font-size:1.5rem;margin:0 0 .8rem;overflow-wrap:anywhere}
h2{font-size:1.15rem;margin:2.2rem 0 .6rem}
.verdict{border-radius:8px;padding:1rem 1.3rem;color:#fff;overflow-wrap:anywhere}
.good{background:#2b8a3e}.bad{background:#c92a2a}.neutral{background:#b35c00}
.verdict strong{font-size:1.6rem;letter-spacing:.03em}
.verdict p{margin:.2rem 0 0}.verdict ul{margin:.6rem 0 0;padding-left:1.2rem}
.caption{font-weight:600;margin:1.2rem 0 .3rem}
.scroll{overflow-x:auto;border:1px solid var(--line);border-radius:6px;background:var(--box)}
table{border-collapse:collapse;width:100%;font-size:14px;font-variant-numeric:tabular-nums}
th,td{padding:.3rem .55rem;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
thead th{background:var(--head);white-space:normal;vertical-align:bottom}
th:first-child,td:first-child{text-align:left;white-space:normal;position:sticky;left:0;
 background:var(--box)}
thead th:first-child{background:var(--head)}
tbody tr:last-child td{border-bottom:0}
tr.quiet{color:var(--quiet)}
tr.missed{color:var(--missed);font-weight:600}
.words th,.words td{white-space:normal;text-align:left;vertical-align:top}
td.good,td.bad,td.neutral{color:#fff}
td.framed{outline:3px solid var(--ink);outline-offset:-3px}
td a{color:inherit}td small{display:block;opacity:.9}
figure{margin:.8rem auto;max-width:60rem;background:var(--box);border:1px solid var(--line);
 border-radius:6px;padding:.4rem}
figure svg{display:block;width:100%;height:auto}
details{background:var(--box);border:1px solid var(--line);border-radius:6px;margin:.5rem 0;
 padding:.4rem .8rem}
pre{overflow-x:auto;font-size:12px;line-height:1.35}
@media (max-width:40rem){
 main{padding:1rem .5rem 3rem}
 table{font-size:13px}th,td{padding:.25rem .4rem}
 figure{padding:.2rem}
 .cas-plot text{font-size:13px}
}
@media print{
 body{background:#fff;font-size:10pt}main{padding:0;max-width:none}
 .verdict{print-color-adjust:exact;-webkit-print-color-adjust:exact}
 figure,.scroll,tr{break-inside:avoid}.scroll{overflow:visible}h2{break-after:avoid}
 details{display:none}
}
)";

constexpr base::EnumWords<Mood::kNeutral> kMoodClasses{"good", "bad", "neutral"};
constexpr base::EnumWords<Look::kMissed> kRowTags{"<tr>", "<tr class=\"quiet\">",
                                                  "<tr class=\"missed\">"};

std::string element(const std::string& name, const std::string& text) {
  return "<" + name + ">" + escape_xml(text) + "</" + name + ">";
}

std::string link_to(const std::string& address, const std::string& text) {
  return "<a href=\"" + escape_xml(address) + "\">" + escape_xml(text) + "</a>";
}

/// Background and text of a share.
std::string share_style(double share) {
  constexpr std::array<std::array<double, 3>, 3> kColours{
      {{217, 72, 15}, {233, 236, 239}, {11, 107, 203}}};
  const double at = std::clamp(share, 0.0, 1.0) * 2;
  const std::size_t low = at < 1 ? 0 : 1;
  std::string colour;
  for (std::size_t i = 0; i < 3; ++i) {
    colour += fmt::format("{:02x}", std::lround(std::lerp(kColours[low][i], kColours[low + 1][i],
                                                          at - static_cast<double>(low))));
  }
  const bool dark = share < 0.2 || share > 0.75;
  return fmt::format(" style=\"background:#{};color:{}\"", colour, dark ? "#fff" : "#212529");
}

std::string cell_element(const Cell& cell) {
  std::string look = cell.mood     ? " class=\"" + std::string(kMoodClasses[*cell.mood]) + "\""
                     : cell.framed ? " class=\"framed\""
                                   : "";
  if (cell.share) look += share_style(*cell.share);
  return "<td" + look + ">" +
         (cell.address.empty() ? escape_xml(cell.text) : link_to(cell.address, cell.text)) +
         (cell.detail.empty() ? "" : element("small", cell.detail)) + "</td>";
}

std::string list_element(const std::vector<std::string>& items) {
  if (items.empty()) return {};
  std::string text = "<ul>";
  for (const std::string& item : items) text += "<li>" + item + "</li>";
  return text + "</ul>";
}

/// Blocks as HTML elements.
struct HtmlBlocks {
  std::string body;

  void operator()(const Document::Verdict& verdict) {
    std::vector<std::string> sentences;
    for (const std::string& each : verdict.sentences) sentences.push_back(escape_xml(each));
    body += "<section class=\"verdict " + std::string(kMoodClasses[verdict.mood]) + "\">" +
            element("strong", verdict.word) + element("p", verdict.line) + list_element(sentences) +
            "</section>\n";
  }
  void operator()(const Document::Heading& heading) { body += element("h2", heading.text) + "\n"; }
  void operator()(const Document::Paragraph& paragraph) {
    body += element("p", paragraph.text) + "\n";
  }
  void operator()(const Document::Table& table) {
    body += "<p class=\"caption\">" + escape_xml(table.caption) +
            "</p><div class=\"scroll\"><table" +
            (table.align == Align::kLeft ? " class=\"words\">\n" : ">\n") + "<thead><tr>";
    for (const Cell& cell : table.rows.front()) body += element("th", cell.text);
    body += "</tr></thead><tbody>\n";
    for (std::size_t i = 1; i < table.rows.size(); ++i) {
      body += kRowTags[i <= table.looks.size() ? table.looks[i - 1] : Look::kPlain];
      for (const Cell& cell : table.rows[i]) body += cell_element(cell);
      body += "</tr>\n";
    }
    body += "</tbody></table></div>\n";
  }
  void operator()(const Plot& plot) {
    body += "<figure>" + to_svg(plot) + plot_block(plot) + "</figure>\n";
  }
  void operator()(const Document::Links& links) {
    std::vector<std::string> items;
    for (const auto& [address, text] : links.list) items.push_back(link_to(address, text));
    body += list_element(items) + "\n";
  }
  void operator()(const Document::Folded& folded) {
    body += "<details>" + element("summary", folded.summary) + element("pre", folded.text) +
            "</details>\n";
  }
};

}  // namespace

std::string write_html(const Document& document) {
  HtmlBlocks blocks{element("h1", document.title) + "\n"};
  for (const Document::Block& block : document.blocks) std::visit(blocks, block);
  return with_plot_script(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n" +
      element("title", document.title) + "<style>" + std::string(kStyle) +
      "</style></head>\n<body><main>\n" + blocks.body + "</main></body></html>\n");
}

}  // namespace cas::hils
