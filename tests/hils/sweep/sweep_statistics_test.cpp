// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cas::hils {
namespace {

// R: binom.test(k, n)$conf.int. None and all: 1 - (0.025)^(1/n).
TEST(ClopperPearson, HasTheKnownEnds) {
  struct IntervalCase {
    const char* name;
    std::size_t successes;
    std::size_t trials;
    double low;
    double high;
  };
  const IntervalCase rows[] = {{"None", 0, 10, 0, 0.3085},
                               {"All", 10, 10, 0.6915, 1},
                               {"EightOfTen", 8, 10, 0.44390, 0.97479},
                               {"Half", 50, 100, 0.39832, 0.60168},
                               {"Nothing", 0, 0, 0, 1}};
  for (const auto& [name, successes, trials, low, high] : rows) {
    SCOPED_TRACE(name);
    const ShareInterval interval = clopper_pearson(successes, trials);
    EXPECT_NEAR(interval.low, low, 5e-5);
    EXPECT_NEAR(interval.high, high, 5e-5);
  }
}

/// All of n stay up: the one-sided bound is alpha^(1/n), the rule of three.
TEST(ClopperPearsonLow, OfAllIsTheRuleOfThree) {
  EXPECT_NEAR(clopper_pearson_low(1000, 1000, 0.95), std::pow(0.05, 1.0 / 1000), 1e-9);
  EXPECT_LT(clopper_pearson_low(2994, 2994, 0.95), 0.999);
  EXPECT_GE(clopper_pearson_low(2995, 2995, 0.95), 0.999);
  EXPECT_EQ(clopper_pearson_low(0, 10, 0.95), 0);
}

// R: fisher.test(matrix(...))$p.value; the first is the lady tasting tea.
TEST(FisherExact, HasTheKnownValues) {
  EXPECT_NEAR(fisher_exact(3, 4, 1, 4), 0.4857142857, 1e-9);
  EXPECT_NEAR(fisher_exact(1, 10, 11, 14), 0.0027594562, 1e-9);
  EXPECT_NEAR(fisher_exact(11, 14, 1, 10), 0.0027594562, 1e-9);
  EXPECT_NEAR(fisher_exact(5, 5, 0, 5), 2.0 / 252, 1e-12);
  EXPECT_EQ(fisher_exact(0, 10, 0, 10), 1);
  EXPECT_EQ(fisher_exact(3, 10, 0, 0), 1);
}

TEST(FisherExact, StandsThousandsOfRuns) {
  EXPECT_NEAR(fisher_exact(9000, 10000, 9000, 10000), 1, 1e-6);
  EXPECT_LT(fisher_exact(8800, 10000, 9000, 10000), 1e-4);
}

/// Intelligence and hours of television, the usual textbook example: -29 / 165.
TEST(Spearman, HasTheKnownValue) {
  const std::vector<double> iq{106, 100, 86, 101, 99, 103, 97, 113, 112, 110};
  const std::vector<double> hours{7, 27, 2, 50, 28, 29, 20, 12, 6, 17};
  const auto rho = spearman(iq, hours);
  ASSERT_TRUE(rho);
  EXPECT_NEAR(rho->rho, -29.0 / 165, 1e-12);
  EXPECT_FALSE(rho->is_significant());
}

TEST(Spearman, SharesRanksOfTiesAndLeavesOutWhatIsNoNumber) {
  const double none = std::nan("");
  const auto rho =
      spearman(std::vector<double>{1, 1, 2, none, 3}, std::vector<double>{1, 2, 3, 4, none});
  ASSERT_TRUE(rho);
  EXPECT_EQ(rho->pairs, 3U);
  EXPECT_NEAR(rho->rho, std::sqrt(3.0) / 2, 1e-12);  // ranks 1.5 1.5 3 against 1 2 3
  EXPECT_FALSE(spearman(std::vector<double>{1, 1, 1}, std::vector<double>{1, 2, 3}));
}

}  // namespace
}  // namespace cas::hils
