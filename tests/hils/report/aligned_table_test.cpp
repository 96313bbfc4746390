// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/aligned_table.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

TEST(AlignedTable, ColumnsAreAsWideAsTheirLongestCell) {
  EXPECT_EQ(aligned_table({{"Name", "Hz", "by"}, {"TCAS", "499.9920", "a"}}, Cells::kLeft),
            "Name  Hz        by\n"
            "TCAS  499.9920  a\n");
}

TEST(AlignedTable, NumbersStandOnTheRight) {
  EXPECT_EQ(
      aligned_table({{"Name", "Hz"}, {"TCAS at 921600", "5.0"}, {"TS", "352.9"}}, Cells::kRight),
      "Name               Hz\n"
      "TCAS at 921600    5.0\n"
      "TS              352.9\n");
}

TEST(AlignedTable, CharactersCountAndNotBytes) {
  EXPECT_EQ(aligned_table({{"", "x"}, {"a", "1 ± 2"}, {"b", "12345"}}, Cells::kRight),
            "       x\n"
            "a  1 ± 2\n"
            "b  12345\n");
}

TEST(AlignedTable, RowsMayBeShort) {
  EXPECT_EQ(aligned_table({{"a", "b"}, {"c"}}, Cells::kLeft), "a  b\nc\n");
  EXPECT_EQ(aligned_table({}, Cells::kLeft), "");
}

}  // namespace
}  // namespace cas::hils
