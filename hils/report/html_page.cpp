// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/html_page.hpp"

#include <string_view>

#include "base/enum_words.hpp"
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
.matrix td{white-space:normal;text-align:left;vertical-align:top}
.matrix td.good,.matrix td.bad,.matrix td.neutral{color:#fff}
.matrix td a{color:inherit}.matrix small{display:block;opacity:.9}
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

std::string_view css_class(HtmlPage::Mood mood) {
  constexpr base::EnumWords<HtmlPage::Mood::kNeutral> kWords{"good", "bad", "neutral"};
  return kWords[mood];
}

std::string_view row_tag(HtmlPage::Row look) {
  constexpr base::EnumWords<HtmlPage::Row::kMissed> kTags{"<tr>", "<tr class=\"quiet\">",
                                                          "<tr class=\"missed\">"};
  return kTags[look];
}

}  // namespace

HtmlPage::HtmlPage(const std::string& title) : title_(title) {
  body_ = "<h1>" + escape_xml(title) + "</h1>\n";
}

void HtmlPage::verdict(Mood mood, const std::string& word, const std::string& line,
                       const std::vector<std::string>& sentences) {
  body_ += "<section class=\"verdict " + std::string(css_class(mood)) + "\"><strong>" +
           escape_xml(word) + "</strong><p>" + escape_xml(line) + "</p>";
  if (!sentences.empty()) {
    body_ += "<ul>";
    for (const std::string& sentence : sentences) body_ += "<li>" + escape_xml(sentence) + "</li>";
    body_ += "</ul>";
  }
  body_ += "</section>\n";
}

void HtmlPage::heading(const std::string& text) { body_ += "<h2>" + escape_xml(text) + "</h2>\n"; }

void HtmlPage::paragraph(const std::string& text) { body_ += "<p>" + escape_xml(text) + "</p>\n"; }

void HtmlPage::table(const std::string& caption, const std::vector<std::vector<std::string>>& rows,
                     const std::vector<Row>& looks) {
  body_ += "<p class=\"caption\">" + escape_xml(caption) + "</p><div class=\"scroll\"><table>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool head = i == 0;
    const Row look = !head && i - 1 < looks.size() ? looks[i - 1] : Row::kPlain;
    const std::string cell = head ? "th" : "td";
    body_ += (head ? "<thead>" : "") + std::string(row_tag(look));
    for (const std::string& text : rows[i]) {
      body_ += "<" + cell + ">" + escape_xml(text) + "</" + cell + ">";
    }
    body_ += head ? "</tr></thead><tbody>\n" : "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void HtmlPage::matrix(const std::string& caption, const std::vector<std::string>& headings,
                      const std::vector<std::vector<Cell>>& rows) {
  body_ += "<p class=\"caption\">" + escape_xml(caption) +
           "</p><div class=\"scroll\"><table class=\"matrix\">\n<thead><tr>";
  for (const std::string& heading : headings) body_ += "<th>" + escape_xml(heading) + "</th>";
  body_ += "</tr></thead><tbody>\n";
  for (const std::vector<Cell>& row : rows) {
    body_ += "<tr>";
    for (const Cell& cell : row) {
      const std::string look =
          cell.mood ? " class=\"" + std::string(css_class(*cell.mood)) + "\"" : "";
      std::string text = escape_xml(cell.text);
      if (!cell.address.empty()) {
        text = "<a href=\"" + escape_xml(cell.address) + "\">" + text + "</a>";
      }
      body_ += "<td" + look + ">" + text;
      if (!cell.detail.empty()) body_ += "<small>" + escape_xml(cell.detail) + "</small>";
      body_ += "</td>";
    }
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void HtmlPage::links(const std::vector<std::pair<std::string, std::string>>& list) {
  body_ += "<ul>";
  for (const auto& [address, text] : list) {
    body_ += "<li><a href=\"" + escape_xml(address) + "\">" + escape_xml(text) + "</a></li>";
  }
  body_ += "</ul>\n";
}

void HtmlPage::figure(const std::string& svg) { body_ += "<figure>" + svg + "</figure>\n"; }

void HtmlPage::plot(const Plot& plot) { figure(to_svg(plot) + plot_block(plot)); }

void HtmlPage::folded(const std::string& summary, const std::string& text) {
  body_ += "<details><summary>" + escape_xml(summary) + "</summary><pre>" + escape_xml(text) +
           "</pre></details>\n";
}

std::string HtmlPage::finish() const {
  return with_plot_script(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
      escape_xml(title_) + "</title><style>" + std::string(kStyle) +
      "</style></head>\n<body><main>\n" + body_ + "</main></body></html>\n");
}

}  // namespace cas::hils
