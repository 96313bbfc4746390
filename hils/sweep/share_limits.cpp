// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/share_limits.hpp"

#include <fmt/format.h>

#include "hils/report/junit.hpp"
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
                        const std::vector<ShareCheck>& checks, const FlightWarnings& warnings) {
  using Outcome = JunitSuite::Outcome;
  JunitSuite suite("hils.sweep." + name);
  const bool all_flown = counts.flown >= counts.rows;
  suite.add("all runs flown", all_flown ? Outcome::kPassed : Outcome::kError,
            all_flown ? ""
                      : fmt::format("{} of {} runs are missing", counts.rows - counts.flown,
                                    counts.rows));
  for (const ShareCheck& check : checks) {
    suite.add(fmt::format("{} at least {:g} % at {:g} % confidence", to_string(check.limit.share),
                          check.limit.at_least * 100, check.limit.confidence * 100),
              check.kept         ? Outcome::kPassed
              : check.trials > 0 ? Outcome::kFailed
                                 : Outcome::kError,
              check.kept ? "" : check.sentence());
  }
  for (const std::string& sentence : warnings.sentences()) suite.say(sentence);
  return suite.report();
}

}  // namespace cas::hils
