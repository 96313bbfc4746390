// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/share_limits.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cas::hils {
namespace {

RowResult row(std::size_t number, RowOutcome outcome, double up) {
  return {.row = number, .outcome = outcome, .figures = {up}};
}

TEST(ShareLimits, CountRunsWithoutAVerdictAgainstTheVehicle) {
  std::vector<RowResult> results(4);
  results[0] = row(1, RowOutcome::kPassed, 1);
  results[1] = row(2, RowOutcome::kFailed, 1);
  results[2] = row(3, RowOutcome::kDied, 0);
  const SweepCounts counts = count(4, results);
  EXPECT_EQ(counts.flown, 3U);
  EXPECT_EQ(counts.judged, 2U);
  EXPECT_EQ(counts.up, 2U);
  EXPECT_EQ(counts.passed, 1U);
  const auto checks = check_shares({{.share = Share::kUp, .at_least = 0.1}}, counts);
  EXPECT_EQ(checks[0].trials, 3U);
}

/// 99.9 % at 95 % confidence takes 2995 runs of which none falls.
TEST(ShareLimits, AreKeptByTheLowerBoundNotByTheShare) {
  const auto kept = [](std::size_t up, std::size_t flown) {
    const SweepCounts counts{.rows = flown, .flown = flown, .judged = flown, .up = up};
    return check_shares({{.share = Share::kUp, .at_least = 0.999, .confidence = 0.95}}, counts)
        .front()
        .kept;
  };
  EXPECT_FALSE(kept(1000, 1000));
  EXPECT_TRUE(kept(2995, 2995));
  EXPECT_FALSE(kept(2994, 2995));
}

TEST(ShareLimits, AreCasesForContinuousIntegration) {
  const SweepCounts counts{.rows = 20, .flown = 10, .judged = 10, .up = 10, .passed = 1};
  const auto checks = check_shares(
      {{.share = Share::kUp, .at_least = 0.5}, {.share = Share::kPassed, .at_least = 0.5}}, counts);
  FlightWarnings warnings;
  warnings.add({"a mass of 1 g"});
  const std::string junit = sweep_junit("a<b", counts, checks, warnings);
  EXPECT_NE(junit.find("name=\"hils.sweep.a&lt;b\" tests=\"3\" failures=\"1\" errors=\"1\""),
            std::string::npos)
      << junit;
  EXPECT_NE(junit.find("10 of 20 runs are missing"), std::string::npos);
  EXPECT_NE(junit.find("passed: 1 of 10 (10.00 %)"), std::string::npos);
  EXPECT_NE(junit.find("warning in 1 of 1 flights: a mass of 1 g"), std::string::npos) << junit;
}

TEST(ShareLimits, AreNotMissedWhereNothingWasFlown) {
  const SweepCounts counts{.rows = 20};
  const auto checks = check_shares({{.share = Share::kUp, .at_least = 0.5}}, counts);
  EXPECT_EQ(checks[0].sentence(), "up: nothing was flown");
  const std::string junit = sweep_junit("a", counts, checks, {});
  EXPECT_NE(junit.find("failures=\"0\" errors=\"2\""), std::string::npos) << junit;
}

}  // namespace
}  // namespace cas::hils
