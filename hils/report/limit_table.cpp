// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/limit_table.hpp"

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

std::vector<std::vector<std::string>> limit_rows(const std::vector<LimitCheck>& checks) {
  std::vector<std::vector<std::string>> rows{{"Limit", "value", "bound", "margin", "result"}};
  for (const LimitCheck& check : checks) {
    const bool decides_validity = check.kind == LimitCheck::Kind::kValidity;
    rows.push_back({(decides_validity ? "validity: " : "") + check.what, value_text(check),
                    bound_text(check), margin_text(check), result_text(check)});
  }
  return rows;
}

}  // namespace cas::hils
