// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/statistics.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "hils/measure/averaging_meter.hpp"

namespace cas::hils {
namespace {

TEST(Estimate, GivesMeanAndStudentInterval) {
  // Mean 3, standard deviation sqrt(2.5), 4 degrees of freedom: 2.776 sqrt(2.5 / 5).
  const Estimate result = estimate(std::array{1.0, 2.0, 3.0, 4.0, 5.0});
  EXPECT_DOUBLE_EQ(result.mean, 3);
  EXPECT_NEAR(result.half_width, 1.9629, 1e-4);
}

TEST(Estimate, OfOneValueHasNoInterval) { EXPECT_EQ(estimate(std::array{7.0}).half_width, 0); }

TEST(Estimate, OfDifferencesCancelsWhatTheSeedsShare) {
  const Estimate result =
      estimate_difference(std::array{1.0, 12.0, 103.0}, std::array{0.0, 11.0, 102.0});
  EXPECT_DOUBLE_EQ(result.mean, 1);
  EXPECT_NEAR(result.half_width, 0, 1e-12);
}

TEST(StudentT, MeetsTheTablesBeyondThirtyDegrees) {
  EXPECT_NEAR(student_t_95(40), 2.0211, 2e-4);
  EXPECT_NEAR(student_t_95(120), 1.9799, 2e-4);
}

std::vector<std::int64_t> steady(double hz, int seconds) {
  std::vector<std::int64_t> arrivals;
  for (int i = 0; i <= static_cast<int>(hz) * seconds; ++i) {
    arrivals.push_back(static_cast<std::int64_t>(i * 1e9 / hz));
  }
  return arrivals;
}

struct MeterCase {
  int seconds;
  double shown_hz;
};

class MeterReading : public testing::TestWithParam<MeterCase> {};

TEST_P(MeterReading, ReadsLowForAWhile) {
  const auto [seconds, shown_hz] = GetParam();
  EXPECT_NEAR(averaging_meter_hz(steady(500, seconds), seconds * 1'000'000'000LL), shown_hz, 0.5);
}

INSTANTIATE_TEST_SUITE_P(At500Hz, MeterReading,
                         testing::Values(MeterCase{5, 336}, MeterCase{10, 446}, MeterCase{20, 494},
                                         MeterCase{30, 499}),
                         [](const auto& test) {
                           return "After" + std::to_string(test.param.seconds) + "Seconds";
                         });

TEST(AveragingMeter, ShowsNothingForNothing) { EXPECT_EQ(averaging_meter_hz({}, 1), 0); }

}  // namespace
}  // namespace cas::hils
