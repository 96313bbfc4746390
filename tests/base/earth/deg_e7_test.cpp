// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/deg_e7.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

TEST(DegE7, IsTheNearestWholeNumberAndComesBackExactly) {
  EXPECT_EQ(deg_e7(47.397742), 473'977'420);
  EXPECT_EQ(deg_e7(-0.00000016), -2);
  EXPECT_EQ(degrees_of_e7(473'977'420), 47.397742);
  for (const std::int32_t value : {-1'800'000'000, -1, 0, 1, 899'999'999, 1'800'000'000}) {
    EXPECT_EQ(deg_e7(degrees_of_e7(value)), value);
  }
}

}  // namespace
}  // namespace cas::base
