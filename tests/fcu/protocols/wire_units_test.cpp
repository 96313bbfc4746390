// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/wire_units.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace cas::fcu {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(WireUnits, AreWholeNumbersOfTheField) {
  EXPECT_EQ(centi(-1.239), -123);
  EXPECT_EQ(milli(1.2346), 1235);
  EXPECT_EQ(deg_e7(47.3979), 473'979'000);
  EXPECT_EQ(heading_cdeg(-M_PI / 2), 27'000);
  EXPECT_EQ(heading_cdeg(-1e-9), 0);
}

TEST(WireUnits, WhatIsNotANumberIsZero) {
  EXPECT_EQ(centi(kNan), 0);
  EXPECT_EQ(milli(kNan), 0);
  EXPECT_EQ(deg_e7(kNan), 0);
  EXPECT_EQ(heading_cdeg(kNan), 0);
  EXPECT_EQ(heading_cdeg(kInfinity), 0);
}

TEST(WireUnits, WhatIsTooLargeStaysInTheField) {
  EXPECT_EQ(centi(kInfinity), 32'767);
  EXPECT_EQ(centi(-400), -32'767);
  EXPECT_EQ(milli(1e9), std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(milli(-kInfinity), std::numeric_limits<std::int32_t>::min());
}

TEST(WireUnits, AnOutputThatIsNotANumberDrivesNothing) {
  EXPECT_EQ(output(kNan, -1, 1), 0.0F);
  EXPECT_EQ(output(kNan, 0, 1), 0.0F);
  EXPECT_EQ(output(1.5, 0, 1), 1.0F);
  EXPECT_EQ(output(-0.25, -1, 1), -0.25F);
}

}  // namespace
}  // namespace cas::fcu
