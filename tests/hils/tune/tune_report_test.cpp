// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace cas::hils {
namespace {

TEST(TuneReport, HasTheWarningsOfAllFlights) {
  TuneResult result;
  result.candidates.resize(1);
  result.warnings.add({"link 'arm': taken as a point mass"});
  result.warnings.add({});
  const Document report = tune_report(TuneStudy{}, result, {});
  const std::string sentence = "warning in 1 of 2 flights: link 'arm': taken as a point mass";
  EXPECT_NE(write_text(report).find(sentence), std::string::npos) << write_text(report);
  EXPECT_NE(write_html(report).find("warning in 1 of 2 flights"), std::string::npos);
}

/// A candidate of one objective that is better in the search.
struct Tuned {
  TuneStudy study;
  TuneResult result;

  Tuned() {
    study.name = "jump";
    study.objectives.push_back(
        {.figure = {.name = "settling", .figures = {"jump_settling_s"}, .in = {}}});
    result.candidates.resize(2);
    for (Candidate& each : result.candidates) each.objectives = {1};
    result.candidates[0].sum = 2;
    result.candidates[1].sum = 1;
    result.candidates[1].number = 1;
    result.best = 1;
  }
  std::string told(double before, double after, std::size_t better) {
    result.verification = {{.scenario = "step",
                            .figure = "settling",
                            .in_search = true,
                            .seeds = 4,
                            .better = better,
                            .before = before,
                            .after = after}};
    return write_text(tune_report(study, result, {}));
  }
};

TEST(TuneReport, IsNoBetterThanItsVerification) {
  Tuned tuned;
  const std::string kept = tuned.told(2, 1, 3);
  EXPECT_NE(kept.find("BETTER: jump: candidate 1 of 1: weighted sum 1 instead of 2; verification: "
                      "settling better with 3 of 4 seeds (step)"),
            std::string::npos)
      << kept;
  EXPECT_EQ(kept.find("A dash"), std::string::npos) << kept;
  for (const std::string& text :
       {tuned.told(2, 1, 2), tuned.told(1, 2, 3), tuned.told(std::nan(""), 1, 3)}) {
    EXPECT_NE(text.find("BETTER IN THE SEARCH: jump"), std::string::npos) << text;
  }
  EXPECT_NE(tuned.told(std::nan(""), std::nan(""), 1).find("A dash: with at least one seed"),
            std::string::npos);
  tuned.told(2, 1, 3);
  tuned.study.objectives[0].weight = 2;
  tuned.study.objectives.push_back({.figure = {.name = "effort", .figures = {}, .in = {}}});
  for (Candidate& each : tuned.result.candidates) each.objectives = {1, 1};
  Verification effort{.scenario = "step", .figure = "effort", .seeds = 4, .better = 0};
  const auto with_effort = [&](double after) {
    effort.before = 1;
    effort.after = after;
    tuned.result.verification.resize(1);
    tuned.result.verification.push_back(effort);
    return write_text(tune_report(tuned.study, tuned.result, {}));
  };
  EXPECT_NE(with_effort(1.9).find("BETTER: jump"), std::string::npos) << "2 x 0.5 less, 0.9 more";
  EXPECT_NE(with_effort(2.1).find("BETTER IN THE SEARCH: jump"), std::string::npos);
  tuned.result.verification.clear();
  const std::string open = write_text(tune_report(tuned.study, tuned.result, {}));
  EXPECT_NE(open.find("not verified with other seeds"), std::string::npos) << open;
}

}  // namespace
}  // namespace cas::hils
