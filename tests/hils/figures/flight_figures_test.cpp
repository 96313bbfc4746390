// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/figures/flight_figures.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "hils/measure/judgement.hpp"
#include "tests/bench/figures/consistency_figures.hpp"

namespace cas::hils {
namespace {

FlightFigure figure(double value, std::optional<double> bound) {
  return {.name = "hover: true x", .value = value, .bound = bound, .unit = "m", .note = ""};
}

TEST(FlightFigures, EndWithOneWhereABoundIsMissed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(exit_code({figure(1, 1), figure(99, std::nullopt)}), kExitPassed);
  EXPECT_EQ(exit_code({figure(1, 1), figure(1.1, 1)}), kExitLimitsMissed);
  EXPECT_EQ(exit_code({figure(kNan, 1)}), kExitLimitsMissed) << "no flight gave a figure";
}

// Table of the chi-square distribution: 300 degrees of freedom, 0.025 and 0.975.
TEST(Consistency, HasTheIntervalOfTheChiSquareDistribution) {
  const ConsistencyInterval interval = consistency_interval(3, 100);
  EXPECT_NEAR(interval.least, 2.539, 1e-3);
  EXPECT_NEAR(interval.most, 3.499, 1e-3);
}

}  // namespace
}  // namespace cas::hils
