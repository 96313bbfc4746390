// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/verbs/param_file.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "tests/support/refusal.hpp"

namespace cas::casctl {
namespace {

// Files with the same three parameters.
TEST(ParamFile, IsRead) {
  struct FileCase {
    const char* name;
    std::string text;
  };
  const FileCase rows[] = {
      {"Casctl", "# saved\nATC_RAT_RLL_P 0.135\nBATT_LOW_MAH -5200\nLOG_BITMASK 958\n"},
      {"MavProxy",
       "ATC_RAT_RLL_P    0.135        # why\n\nBATT_LOW_MAH     -5200.000000\n"
       "LOG_BITMASK      +958\n"},
      {"ArdupilotDefaults",
       "ATC_RAT_RLL_P 0.135\nBATT_LOW_MAH -0x1450 @READONLY\nLOG_BITMASK\t0x3BE"},
      {"MissionPlanner",
       "#NOTE: 11/22/2026\r\nATC_RAT_RLL_P,0.135\r\nBATT_LOW_MAH, -5200\r\n"
       "LOG_BITMASK , 958\r\n"},
      {"QGroundControl",
       "# Vehicle-Id Component-Id Name Value Type\n1\t1\tATC_RAT_RLL_P\t0.135\t9\n"
       "1\t1\tBATT_LOW_MAH\t-5200\t6\n1\t1\tLOG_BITMASK\t958\t6\n"},
      {"OldQGroundControl",
       "1 1 ATC_RAT_RLL_P 0.135\n1 1 BATT_LOW_MAH -5200\n1 1 LOG_BITMASK 958\n"},
      {"ByteOrderMarkAndCr",
       "\xef\xbb\xbf"
       "ATC_RAT_RLL_P 1.35e-1\rBATT_LOW_MAH -5200\rLOG_BITMASK 958"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const std::vector<ParamWish> wishes = parse_param_file(row.text, "a.params");
    ASSERT_EQ(wishes.size(), 3U);
    EXPECT_EQ(wishes[0].name, "ATC_RAT_RLL_P");
    EXPECT_EQ(wishes[0].value, 0.135);
    EXPECT_EQ(wishes[1].name, "BATT_LOW_MAH");
    EXPECT_EQ(wishes[1].value, -5200);
    EXPECT_EQ(wishes[2].name, "LOG_BITMASK");
    EXPECT_EQ(wishes[2].value, 958);
  }
}

TEST(ParamFileRow, OfQGroundControlNamesItsComponent) {
  EXPECT_EQ(parse_param_file("1\t154\tMNT_MODE\t2\t6\n", "a.params").at(0).component, 154);
  EXPECT_EQ(parse_param_file("MNT_MODE 2\n", "a.params").at(0).component, 0);
}

TEST(RefusedParamFile, IsNamedWithItsLine) {
  struct RefusedCase {
    const char* name;
    std::string text;
    std::string why;
  };
  const RefusedCase rows[] = {{"DecimalComma", "A 1\nB 0,135\n", "a.params:2: expected NAME VALUE"},
                              {"DecimalCommaBehindComma", "B,0,135\n", "a.params:1:"},
                              {"DecimalCommaInColumns", "1 1 B 0,135\n", "a.params:1:"},
                              {"DecimalCommaInFiveColumns", "1 1 B 0,135 9\n", "a.params:1:"},
                              {"ALineWithoutValue", "A 1\r\nB\r\nC 2\r\n", "a.params:2:"},
                              {"AWord", "A none\n", "a.params:1:"},
                              {"TwoSigns", "A --1\n", "a.params:1:"},
                              {"TooLongAName", "ABCDEFGHIJKLMNOPQ 1\n", "a.params:1:"},
                              {"OnlyComments", "# nothing\n\n", "holds no parameter"},
                              {"AnEmptyFile", "", "holds no parameter"},
                              {"Utf16",
                               std::string("\xff\xfe"
                                           "A\0 \0",
                                           6),
                               "save it as UTF-8"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const std::string said =
        cas::test::refusal<std::runtime_error>([&] { parse_param_file(row.text, "a.params"); });
    EXPECT_NE(said.find(row.why), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace cas::casctl
