// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/share_limits.hpp"

#include <fmt/format.h>

#include "hils/report/plot.hpp"
#include "hils/sweep/sweep_statistics.hpp"

namespace cas::hils {

std::size_t SweepCounts::of(Share share) const {
  switch (share) {
    case Share::kUp:
      return up;
    case Share::kPassed:
      return passed;
    case Share::kJudged:
      break;
  }
  return judged;
}

SweepCounts count(std::size_t rows, const std::vector<RowResult>& results) {
  SweepCounts counts{.rows = rows};
  for (const RowResult& result : results) {
    if (result.row == 0) continue;
    ++counts.flown;
    if (!is_judged(result.outcome)) continue;
    ++counts.judged;
    if (result.outcome == RowOutcome::kPassed) ++counts.passed;
    if (result.figures.size() > kUpFigure && result.figures[kUpFigure] == 1) ++counts.up;
  }
  return counts;
}

std::string ShareCheck::sentence() const {
  if (trials == 0) return fmt::format("{}: nothing was flown", to_string(limit.share));
  const double share = static_cast<double>(successes) / static_cast<double>(trials) * 100;
  return fmt::format(
      "{}: {} of {} ({:.2f} %), at least {:.2f} % at {:g} % confidence; the limit "
      "is {:g} %",
      to_string(limit.share), successes, trials, share, low * 100, limit.confidence * 100,
      limit.at_least * 100);
}

std::vector<ShareCheck> check_shares(const std::vector<ShareLimit>& limits,
                                     const SweepCounts& counts) {
  std::vector<ShareCheck> checks;
  for (const ShareLimit& limit : limits) {
    ShareCheck check{.limit = limit, .successes = counts.of(limit.share), .trials = counts.flown};
    check.low = clopper_pearson_low(check.successes, check.trials, limit.confidence);
    check.kept = check.low >= limit.at_least;
    checks.push_back(check);
  }
  return checks;
}

std::string sweep_junit(const std::string& name, const SweepCounts& counts,
                        const std::vector<ShareCheck>& checks) {
  const std::string suite = escape_xml("hils.sweep." + name);
  std::string cases;
  std::size_t failures = 0;
  std::size_t errors = 0;
  const auto open = [&suite](const std::string& title) {
    return fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"0\"", suite,
                       escape_xml(title));
  };
  cases += open("all runs flown");
  if (counts.flown < counts.rows) {
    ++errors;
    cases += fmt::format("><error message=\"{} of {} runs are missing\"/></testcase>\n",
                         counts.rows - counts.flown, counts.rows);
  } else {
    cases += "/>\n";
  }
  for (const ShareCheck& check : checks) {
    cases +=
        open(fmt::format("{} at least {:g} % at {:g} % confidence", to_string(check.limit.share),
                         check.limit.at_least * 100, check.limit.confidence * 100));
    if (check.kept) {
      cases += "/>\n";
      continue;
    }
    ++(check.trials > 0 ? failures : errors);
    cases += fmt::format("><{} message=\"{}\"/></testcase>\n",
                         check.trials > 0 ? "failure" : "error", escape_xml(check.sentence()));
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" "
      "failures=\"{}\" errors=\"{}\">\n{}</testsuite>\n",
      suite, checks.size() + 1, failures, errors, cases);
}

}  // namespace cas::hils
