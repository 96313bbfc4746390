// SPDX-License-Identifier: BSD-3-Clause
#include "base/number_text.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace cas::base {
namespace {

TEST(NumberText, AWordIsANumberOnlyAsAWhole) {
  EXPECT_EQ(number_of<double>("-9.8"), -9.8);
  EXPECT_EQ(number_of<double>("+1e-3"), 1e-3);
  EXPECT_EQ(number_of<double>(".5"), 0.5);
  EXPECT_EQ(number_of<std::uint32_t>("17"), 17u);
  for (const char* word : {"", "0,5", "-9,8", "0.5m", "1-2", "+-1", "--1", "nan", "inf", "-inf",
                           "1e999", "0x10", "1.5.2", "1 2"}) {
    EXPECT_FALSE(number_of<double>(word)) << word;
  }
  for (const char* word : {"", "-1", "1.5", "4294967296", "7/1"}) {
    EXPECT_FALSE(number_of<std::uint32_t>(word)) << word;
  }
}

TEST(NumberText, AListEndsAtTheFirstWordThatIsNone) {
  std::vector<double> values;
  EXPECT_FALSE(read_numbers(" 1\t2\r\n3 ", values));
  EXPECT_EQ(values, (std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(read_numbers("  ", values));
  EXPECT_EQ(values.size(), 3u) << "appended to";
  EXPECT_EQ(read_numbers("4 0,5 6", values), "0,5");
  EXPECT_EQ(values.back(), 4);
}

TEST(NumberText, ARefusalNamesTheWordAndTheComma) {
  EXPECT_EQ(no_number("0.5m"), "'0.5m' is no number (a number alone, without a unit)");
  EXPECT_EQ(no_number("1e999"), "'1e999' is no number");
  EXPECT_EQ(no_number("0,5"), "'0,5' is no number (decimals follow a point, not a comma)");
  EXPECT_EQ(no_number(std::string(60, 'x')).size(), 40u + std::string("'...' is no number").size());
}

}  // namespace
}  // namespace cas::base
