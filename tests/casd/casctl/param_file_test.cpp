// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/verbs/param_file.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace cas::casctl {
namespace {

struct FileCase {
  const char* name;
  std::string text;
};

/// Files with the same three parameters.
class ParamFile : public testing::TestWithParam<FileCase> {};

TEST_P(ParamFile, IsRead) {
  const std::vector<ParamWish> wishes = parse_param_file(GetParam().text, "a.params");
  ASSERT_EQ(wishes.size(), 3U);
  EXPECT_EQ(wishes[0].name, "ATC_RAT_RLL_P");
  EXPECT_EQ(wishes[0].value, 0.135);
  EXPECT_EQ(wishes[1].name, "BATT_LOW_MAH");
  EXPECT_EQ(wishes[1].value, -5200);
  EXPECT_EQ(wishes[2].name, "LOG_BITMASK");
  EXPECT_EQ(wishes[2].value, 958);
}

INSTANTIATE_TEST_SUITE_P(
    Of, ParamFile,
    testing::Values(
        FileCase{"Casctl", "# saved\nATC_RAT_RLL_P 0.135\nBATT_LOW_MAH -5200\nLOG_BITMASK 958\n"},
        FileCase{"MavProxy",
                 "ATC_RAT_RLL_P    0.135        # why\n\nBATT_LOW_MAH     -5200.000000\n"
                 "LOG_BITMASK      +958\n"},
        FileCase{"ArdupilotDefaults",
                 "ATC_RAT_RLL_P 0.135\nBATT_LOW_MAH -0x1450 @READONLY\nLOG_BITMASK\t0x3BE"},
        FileCase{"MissionPlanner",
                 "#NOTE: 11/22/2026\r\nATC_RAT_RLL_P,0.135\r\nBATT_LOW_MAH, -5200\r\n"
                 "LOG_BITMASK , 958\r\n"},
        FileCase{"QGroundControl",
                 "# Vehicle-Id Component-Id Name Value Type\n1\t1\tATC_RAT_RLL_P\t0.135\t9\n"
                 "1\t1\tBATT_LOW_MAH\t-5200\t6\n1\t1\tLOG_BITMASK\t958\t6\n"},
        FileCase{"OldQGroundControl",
                 "1 1 ATC_RAT_RLL_P 0.135\n1 1 BATT_LOW_MAH -5200\n1 1 LOG_BITMASK 958\n"},
        FileCase{"ByteOrderMarkAndCr",
                 "\xef\xbb\xbf"
                 "ATC_RAT_RLL_P 1.35e-1\rBATT_LOW_MAH -5200\rLOG_BITMASK 958"}),
    [](const auto& test) { return test.param.name; });

TEST(ParamFileRow, OfQGroundControlNamesItsComponent) {
  EXPECT_EQ(parse_param_file("1\t154\tMNT_MODE\t2\t6\n", "a.params").at(0).component, 154);
  EXPECT_EQ(parse_param_file("MNT_MODE 2\n", "a.params").at(0).component, 0);
}

struct RefusedCase {
  const char* name;
  std::string text;
  std::string why;
};

class RefusedParamFile : public testing::TestWithParam<RefusedCase> {};

TEST_P(RefusedParamFile, IsNamedWithItsLine) {
  try {
    parse_param_file(GetParam().text, "a.params");
    FAIL() << "it was read";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam().why), std::string::npos) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of, RefusedParamFile,
    testing::Values(RefusedCase{"DecimalComma", "A 1\nB 0,135\n",
                                "a.params:2: expected NAME VALUE"},
                    RefusedCase{"DecimalCommaBehindComma", "B,0,135\n", "a.params:1:"},
                    RefusedCase{"DecimalCommaInColumns", "1 1 B 0,135\n", "a.params:1:"},
                    RefusedCase{"DecimalCommaInFiveColumns", "1 1 B 0,135 9\n", "a.params:1:"},
                    RefusedCase{"ALineWithoutValue", "A 1\r\nB\r\nC 2\r\n", "a.params:2:"},
                    RefusedCase{"AWord", "A none\n", "a.params:1:"},
                    RefusedCase{"TwoSigns", "A --1\n", "a.params:1:"},
                    RefusedCase{"TooLongAName", "ABCDEFGHIJKLMNOPQ 1\n", "a.params:1:"},
                    RefusedCase{"OnlyComments", "# nothing\n\n", "holds no parameter"},
                    RefusedCase{"AnEmptyFile", "", "holds no parameter"},
                    RefusedCase{"Utf16",
                                std::string("\xff\xfe"
                                            "A\0 \0",
                                            6),
                                "save it as UTF-8"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cas::casctl
