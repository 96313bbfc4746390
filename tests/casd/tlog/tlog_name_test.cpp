// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_name.hpp"

#include <gtest/gtest.h>

namespace cas::casd {
namespace {

TEST(TlogName, StandsForAFileInOneFolderAlone) {
  struct NameCase {
    const char* name;
    std::string given;
    std::optional<std::string> fault;
  };
  const NameCase rows[] = {{"Plain", "flight", {}},
                           {"WithExtension", "flight.tlog", {}},
                           {"WithSpaceAndDots", "wing 2..b", {}},
                           {"OtherLetters", "Flügel", {}},
                           {"Empty", "", "is empty"},
                           {"Absolute", "/etc/x", "has a slash"},
                           {"Relative", "a/x", "has a slash"},
                           {"Parent", "..", "begins with a dot"},
                           {"Hidden", ".tlog", "begins with a dot"},
                           {"Nul", std::string("a\0b", 3), "has unprintable characters"},
                           {"NewLine", "a\nb", "has unprintable characters"},
                           {"Tab", "a\tb", "has unprintable characters"},
                           {"RightToLeft", "a\u202Egolt", "has unprintable characters"},
                           {"TooLong", std::string(101, 'a'), "has more than 100 characters"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const std::optional<std::string> fault = tlog_name_fault(row.given);
    EXPECT_EQ(fault, row.fault);
  }
}

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
