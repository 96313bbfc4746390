// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/verdict_section.hpp"

#include <algorithm>
#include <vector>

#include "hils/report/limit_table.hpp"

namespace cas::hils {

std::string title_of(const Verdict& verdict) {
  if (!verdict.valid) return "Not valid";
  return verdict.passed ? "Passed" : "Failed";
}

void add_verdict(HtmlPage& page, const Verdict& verdict, const std::string& line) {
  const auto mood = !verdict.valid   ? HtmlPage::Mood::kNeutral
                    : verdict.passed ? HtmlPage::Mood::kGood
                                     : HtmlPage::Mood::kBad;
  page.verdict(mood, title_of(verdict), line, verdict.failures);
  for (const std::string& remark : verdict.remarks) page.paragraph("Note: " + remark + ".");
  for (const std::string& warning : verdict.warnings) page.paragraph("Warning: " + warning + ".");
}

void add_limits(HtmlPage& page, const std::string& caption, const Verdict& verdict) {
  std::vector<LimitCheck> checks = verdict.checks;
  std::stable_partition(checks.begin(), checks.end(), [&verdict](const LimitCheck& check) {
    return check.judged && (check.kind == LimitCheck::Kind::kFlight) == verdict.valid;
  });
  std::vector<HtmlPage::Row> looks;
  looks.reserve(checks.size());
  for (const LimitCheck& check : checks) {
    looks.push_back(!check.judged ? HtmlPage::Row::kQuiet
                    : check.kept  ? HtmlPage::Row::kPlain
                                  : HtmlPage::Row::kMissed);
  }
  page.table(caption, limit_rows(checks), looks);
}

}  // namespace cas::hils
