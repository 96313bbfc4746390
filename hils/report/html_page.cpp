// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/html_page.hpp"

#include <algorithm>
#include <string_view>

#include "hils/report/plot.hpp"

namespace cas::hils {

namespace {

constexpr std::string_view kStyle = R"(
:root{color-scheme:light}
body{font:15px/1.5 system-ui,sans-serif;color:#212529;background:#f1f3f5;margin:0}
main{max-width:60rem;margin:0 auto;padding:1.5rem 1rem 4rem}
h1{font-size:1.5rem;margin:0 0 .8rem}
h2{font-size:1.15rem;margin:2.2rem 0 .6rem}
.verdict{border-radius:8px;padding:1rem 1.3rem;color:#fff}
.good{background:#2b8a3e}.bad{background:#c92a2a}.neutral{background:#e67700}
.verdict strong{font-size:1.6rem;letter-spacing:.03em}
.verdict p{margin:.2rem 0 0}.verdict ul{margin:.6rem 0 0;padding-left:1.2rem}
.scroll{overflow-x:auto}
table{border-collapse:collapse;background:#fff;width:100%;font-variant-numeric:tabular-nums}
caption{text-align:left;font-weight:600;padding:.5rem 0}
th,td{padding:.3rem .7rem;text-align:right;border-bottom:1px solid #e9ecef;white-space:nowrap}
th:first-child,td:first-child{text-align:left}
thead th{background:#e9ecef}
tr.quiet{color:#868e96}
figure{margin:.8rem 0;background:#fff;border:1px solid #e9ecef;border-radius:6px;padding:.4rem}
figure svg{display:block;width:100%;height:auto}
details{background:#fff;border:1px solid #e9ecef;border-radius:6px;margin:.5rem 0;padding:.4rem .8rem}
pre{overflow-x:auto;font-size:12px;line-height:1.35}
@media print{
 body{background:#fff;font-size:10pt}main{padding:0;max-width:none}
 .verdict{print-color-adjust:exact;-webkit-print-color-adjust:exact}
 figure,table,tr{break-inside:avoid}h2{break-after:avoid}details{display:none}
}
)";

std::string_view css_class(HtmlPage::Mood mood) {
  switch (mood) {
    case HtmlPage::Mood::kGood:
      return "good";
    case HtmlPage::Mood::kBad:
      return "bad";
    case HtmlPage::Mood::kNeutral:
      break;
  }
  return "neutral";
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
                     const std::vector<std::size_t>& quiet_rows) {
  body_ += "<div class=\"scroll\"><table><caption>" + escape_xml(caption) + "</caption>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool head = i == 0;
    const bool quiet = !head && std::ranges::count(quiet_rows, i - 1) > 0;
    const std::string cell = head ? "th" : "td";
    body_ += head ? "<thead><tr>" : quiet ? "<tr class=\"quiet\">" : "<tr>";
    for (const std::string& text : rows[i]) {
      body_ += "<" + cell + ">" + escape_xml(text) + "</" + cell + ">";
    }
    body_ += head ? "</tr></thead><tbody>\n" : "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void HtmlPage::figure(const std::string& svg) { body_ += "<figure>" + svg + "</figure>\n"; }

void HtmlPage::folded(const std::string& summary, const std::string& text) {
  body_ += "<details><summary>" + escape_xml(summary) + "</summary><pre>" + escape_xml(text) +
           "</pre></details>\n";
}

std::string HtmlPage::finish() const {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
         escape_xml(title_) + "</title><style>" + std::string(kStyle) +
         "</style></head>\n<body><main>\n" + body_ + "</main></body></html>\n";
}

}  // namespace cas::hils
