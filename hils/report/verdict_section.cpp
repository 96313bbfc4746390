// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/verdict_section.hpp"

#include <fmt/format.h>

#include "hils/report/number_text.hpp"

namespace cas::hils {

namespace {

std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

std::string value_text(const LimitCheck& check) {
  return check.value ? with_unit(fixed(*check.value, check.digits), check.unit) : check.found;
}

std::string bound_text(const LimitCheck& check) {
  if (!check.bound) return check.wanted;
  const char* const sign = check.sense == LimitCheck::Sense::kAtMost ? "≤" : "≥";
  return with_unit(fmt::format("{} {:g}", sign, *check.bound), check.unit);
}

std::string margin_text(const LimitCheck& check) {
  const std::optional<double> margin = check.margin();
  if (!margin) return "";
  const std::string text = with_unit(fixed(*margin, check.digits), check.unit);
  if (!check.bound || *check.bound == 0) return text;
  return fmt::format("{} ({} %)", text, fixed(100 * *margin / *check.bound, 0));
}

std::string result_text(const LimitCheck& check) {
  if (!check.judged) return "not judged";
  return check.kept ? "passed" : "missed";
}

}  // namespace

Document::Verdict verdict_block(const Verdict& verdict, const std::string& line) {
  const Mood mood = !verdict.valid ? Mood::kNeutral : verdict.passed ? Mood::kGood : Mood::kBad;
  Document::Verdict block{mood, std::string(verdict.word()), line, verdict.failures};
  for (const std::string& remark : verdict.remarks) block.sentences.push_back("note: " + remark);
  for (const std::string& each : verdict.warnings) block.sentences.push_back("warning: " + each);
  return block;
}

Document::Table limit_table(const std::string& caption, const Verdict& verdict) {
  std::vector<LimitCheck> checks = verdict.checks;
  std::stable_partition(checks.begin(), checks.end(), [&verdict](const LimitCheck& check) {
    return check.judged && (check.kind == LimitCheck::Kind::kFlight) == verdict.valid;
  });
  Document::Table table{caption, {{"Limit", "value", "bound", "margin", "result"}}};
  for (const LimitCheck& check : checks) {
    const bool decides_validity = check.kind == LimitCheck::Kind::kValidity;
    table.rows.push_back({(decides_validity ? "validity: " : "") + check.what, value_text(check),
                          bound_text(check), margin_text(check), result_text(check)});
    table.looks.push_back(!check.judged ? Look::kQuiet : check.kept ? Look::kPlain : Look::kMissed);
  }
  return table;
}

}  // namespace cas::hils
