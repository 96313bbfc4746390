// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/verdict_section.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

/// Of checks that all decide.
Rows rows_of(const std::vector<LimitCheck>& checks) {
  Verdict verdict{.valid = true, .passed = true, .failures = {}};
  verdict.checks = checks;
  return limit_table("", verdict).rows;
}

TEST(LimitTable, ShowsTheMarginBelowAnUpperBound) {
  const auto rows = rows_of({{.what = "RMS", .unit = "m", .value = 0.0532, .bound = 0.25}});
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1], (Row{"RMS", "0.0532 m", "≤ 0.25 m", "0.1968 m (79 %)", "passed"}));
}

TEST(LimitTable, ShowsTheMarginAboveALowerBound) {
  const auto rows = rows_of({{.what = "delivered",
                              .unit = "%",
                              .digits = 1,
                              .sense = LimitCheck::Sense::kAtLeast,
                              .value = 99.5,
                              .bound = 80}});
  EXPECT_EQ(rows[1], (Row{"delivered", "99.5 %", "≥ 80 %", "19.5 % (24 %)", "passed"}));
}

TEST(LimitTable, ShowsANegativeMarginWhereALimitWasMissed) {
  const auto rows = rows_of({{.what = "loop",
                              .unit = "us",
                              .digits = 0,
                              .value = 6000,
                              .bound = 5000,
                              .kept = false,
                              .sentence = "too slow"}});
  EXPECT_EQ(rows[1], (Row{"loop", "6000 us", "≤ 5000 us", "-1000 us (-20 %)", "missed"}));
}

TEST(LimitTable, HasNoShareOfABoundThatIsZero) {
  const auto rows = rows_of({{.what = "lost", .digits = 0, .value = 0, .bound = 0}});
  EXPECT_EQ(rows[1], (Row{"lost", "0", "≤ 0", "0", "passed"}));
}

TEST(LimitTable, SaysInWordsWhatIsNoNumber) {
  const auto rows = rows_of({{.what = "incident: crash", .found = "none", .wanted = "none"},
                             {.kind = LimitCheck::Kind::kValidity,
                              .what = "account of HIL_GPS",
                              .found = "closes",
                              .wanted = "closes"}});
  EXPECT_EQ(rows[1], (Row{"incident: crash", "none", "none", "", "passed"}));
  EXPECT_EQ(rows[2], (Row{"validity: account of HIL_GPS", "closes", "closes", "", "passed"}));
}

TEST(LimitTable, PassesNothingThatWasNotJudged) {
  const auto rows = rows_of({{.what = "lost", .value = 0, .bound = 0, .judged = false}});
  EXPECT_EQ(rows[1].back(), "not judged");
}

}  // namespace
}  // namespace cas::hils
