// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/log_thinning.hpp"

#include <gtest/gtest.h>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

TEST(LogThinning, LeavesOutWhatIsMoreThanAMinuteHasRoomFor) {
  LogThinning thinning;
  int written = 0;
  int last = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto verdict = thinning.on_line(at(milliseconds(i)));
    written += verdict != LogThinning::Verdict::kLeaveOut ? 1 : 0;
    last += verdict == LogThinning::Verdict::kLast ? 1 : 0;
  }
  EXPECT_EQ(written, LogThinning::kLines);
  EXPECT_EQ(last, 1);
  EXPECT_EQ(thinning.on_line(at(LogThinning::kPeriod)), LogThinning::Verdict::kWrite);
}

TEST(LogThinning, WritesEachOfFewLines) {
  LogThinning thinning;
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(thinning.on_line(at(std::chrono::seconds(4 * i))), LogThinning::Verdict::kWrite);
  }
}

}  // namespace
}  // namespace cas::casd::test
