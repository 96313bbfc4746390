// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/number_text.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

TEST(Fixed, LeavesZeroWithoutASign) {
  EXPECT_EQ(fixed(-0.00004, 4), "0.0000");
  EXPECT_EQ(fixed(-0.0, 2), "0.00");
  EXPECT_EQ(fixed(-0.4, 0), "0");
  EXPECT_EQ(fixed(0.00004, 4), "0.0000");
}

TEST(Fixed, KeepsTheSignOfWhatIsNotZero) {
  EXPECT_EQ(fixed(-0.00006, 4), "-0.0001");
  EXPECT_EQ(fixed(-0.6, 0), "-1");
  EXPECT_EQ(fixed(-100, 1), "-100.0");
}

TEST(Fixed, WritesADashForNothing) {
  EXPECT_EQ(fixed(std::nullopt, 2), "-");
  EXPECT_EQ(fixed(std::optional<double>(-1.5), 1), "-1.5");
}

}  // namespace
}  // namespace cas::hils
