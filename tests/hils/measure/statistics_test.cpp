// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/statistics.hpp"

#include <gtest/gtest.h>

#include <array>

namespace cas::hils {
namespace {

TEST(Mean, GivesMeanAndStudentInterval) {
  // Mean 3, standard deviation sqrt(2.5), 4 degrees of freedom: 2.7764 sqrt(2.5 / 5).
  const Mean result = mean_of(std::array{1.0, 2.0, 3.0, 4.0, 5.0});
  EXPECT_DOUBLE_EQ(result.mean, 3);
  EXPECT_NEAR(result.half_width, 1.9632, 1e-4);
}

TEST(Mean, OfOneValueHasNoInterval) { EXPECT_EQ(mean_of(std::array{7.0}).half_width, 0); }

TEST(Mean, OfDifferencesCancelsWhatTheSeedsShare) {
  const Mean result = mean_difference(std::array{1.0, 12.0, 103.0}, std::array{0.0, 11.0, 102.0});
  EXPECT_DOUBLE_EQ(result.mean, 1);
  EXPECT_NEAR(result.half_width, 0, 1e-12);
}

TEST(StudentT, MeetsTheTables) {
  EXPECT_NEAR(student_t_95(1), 12.706, 5e-4);
  EXPECT_NEAR(student_t_95(10), 2.228, 5e-4);
  EXPECT_NEAR(student_t_95(120), 1.9799, 5e-5);
}

}  // namespace
}  // namespace cas::hils
