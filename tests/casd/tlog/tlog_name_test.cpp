// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_name.hpp"

#include <gtest/gtest.h>

namespace cas::casd {
namespace {

struct NameCase {
  const char* name;
  std::string given;
  std::optional<std::string> fault;
};

class TlogName : public testing::TestWithParam<NameCase> {};

TEST_P(TlogName, StandsForAFileInOneFolderAlone) {
  const std::optional<std::string> fault = tlog_name_fault(GetParam().given);
  EXPECT_EQ(fault, GetParam().fault);
}

INSTANTIATE_TEST_SUITE_P(
    Cases, TlogName,
    testing::Values(NameCase{"Plain", "flight", {}}, NameCase{"WithExtension", "flight.tlog", {}},
                    NameCase{"WithSpaceAndDots", "wing 2..b", {}},
                    NameCase{"OtherLetters", "Flügel", {}}, NameCase{"Empty", "", "is empty"},
                    NameCase{"Absolute", "/etc/x", "has a slash"},
                    NameCase{"Relative", "a/x", "has a slash"},
                    NameCase{"Parent", "..", "begins with a dot"},
                    NameCase{"Hidden", ".tlog", "begins with a dot"},
                    NameCase{"Nul", std::string("a\0b", 3), "has unprintable characters"},
                    NameCase{"NewLine", "a\nb", "has unprintable characters"},
                    NameCase{"Tab", "a\tb", "has unprintable characters"},
                    NameCase{"RightToLeft", "a\u202Egolt", "has unprintable characters"},
                    NameCase{"TooLong", std::string(101, 'a'), "has more than 100 characters"}),
    [](const auto& test) { return test.param.name; });

TEST(DatedTlogName, HasTheMomentInUtcFirst) {
  constexpr std::chrono::seconds kMoment{1'795'370'700};
  EXPECT_EQ(dated_tlog_name(kMoment, "flight"), "2026-11-22T18-05-00Z-flight");
  EXPECT_EQ(dated_tlog_name(kMoment, ""), "2026-11-22T18-05-00Z");
  EXPECT_EQ(tlog_file_name("a", 0), "a.tlog");
  EXPECT_EQ(tlog_file_name("a", 12), "a.12.tlog");
  EXPECT_EQ(bare_tlog_name("a.tlog"), "a");
  EXPECT_EQ(bare_tlog_name("a"), "a");
}

}  // namespace
}  // namespace cas::casd
