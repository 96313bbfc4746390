// SPDX-License-Identifier: BSD-3-Clause
#include "base/error.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

TEST(CheckDeathTest, AFalseConditionAbortsWithFileAndCondition) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const int rotors = 3;
  EXPECT_DEATH(CAS_CHECK(rotors == 4), "error_test.cpp:[0-9]+: check failed: rotors == 4");
}

TEST(Check, ATrueConditionIsEvaluatedOnce) {
  int evaluations = 0;
  CAS_CHECK(++evaluations > 0);
  EXPECT_EQ(evaluations, 1);
}

}  // namespace
}  // namespace cas::base
