// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/journal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

RowResult result_of(std::size_t row) {
  return {.row = row,
          .outcome = RowOutcome::kFailed,
          .cause = "crash: \"hit\", 3 m/s",
          .incident = "crash",
          .unfinished = "takeoff",
          .version = "0.1.0",
          .figures = {0, std::nan(""), 0.1 + 0.2},
          .machine = {.wall_s = 0.5, .cpu_s = 0.4, .max_rss_mib = 20, .host = "lab"}};
}

TEST(Journal, ALineComesBackToTheBit) {
  const RowResult written = result_of(7);
  const auto read = parse_journal_line(journal_line(written));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->row, 7U);
  EXPECT_EQ(read->outcome, RowOutcome::kFailed);
  EXPECT_EQ(read->cause, written.cause);
  EXPECT_EQ(read->unfinished, "takeoff");
  EXPECT_EQ(read->figures[2], 0.1 + 0.2);
  EXPECT_TRUE(std::isnan(read->figures[1]));
  EXPECT_EQ(result_fields(*read, 4),
            ",failed,0,,0.30000000000000004,,crash,\"crash: \"\"hit\"\", 3 m/s\",0.1.0,");
}

TEST(Journal, ACauseIsOneLineThatATerminalMayShow) {
  EXPECT_EQ(row_without_figures(RowOutcome::kRefused, "no\n'\x1b[31m'").cause, "no ' [31m'");
}

TEST(Journal, AStrikeComesBack) {
  RowResult written = result_of(3);
  written.run_sha256 = "f00d";
  written.strike = StrikeResponse{.strike_s = 12.5,
                                  .fault = "gps_lost in hover",
                                  .no_verdict = "never acted: it struck after the flight",
                                  .armed_before = true,
                                  .armed_after = true,
                                  .detected_s = 0.1 + 0.2,
                                  .detected_by = "'Position lost: descending'",
                                  .reacted_s = std::nullopt,
                                  .incident = IncidentKind::kFlyaway,
                                  .crashed = true,
                                  .rest_m = std::nan(""),
                                  .farthest_m = HUGE_VAL};
  const auto read = parse_journal_line(journal_line(written));
  ASSERT_TRUE(read && read->strike);
  EXPECT_EQ(read->run_sha256, "f00d");
  EXPECT_EQ(read->strike->detected_s, 0.1 + 0.2);
  EXPECT_EQ(read->strike->detected_by, written.strike->detected_by);
  EXPECT_FALSE(read->strike->reacted_s);
  EXPECT_EQ(read->strike->incident, IncidentKind::kFlyaway);
  EXPECT_TRUE(read->strike->crashed);
  EXPECT_FALSE(read->strike->at_rest);
  EXPECT_TRUE(std::isnan(read->strike->rest_m));
  EXPECT_EQ(read->strike->farthest_m, HUGE_VAL);
  EXPECT_EQ(read->strike->no_verdict, written.strike->no_verdict);
  EXPECT_FALSE(parse_journal_line(journal_line(result_of(3)))->strike);
}

/// Whatever part of the last line a power failure left, the others stay and it can go on.
TEST(Journal, WhatIsTornAtTheEndIsCutOff) {
  const std::string one = journal_line(result_of(1));
  const std::string two = journal_line(result_of(2));
  for (std::size_t kept = 0; kept < two.size(); ++kept) {
    const test::TemporaryFolder folder;
    const auto file = folder.write("journal.jsonl", one + two.substr(0, kept));
    EXPECT_FALSE(kept > 0 && kept + 1 < two.size() && parse_journal_line(two.substr(0, kept)));
    Journal(file).append(result_of(3));
    EXPECT_EQ(test::TemporaryFolder::read(file), one + journal_line(result_of(3)));
  }
}

TEST(Journal, IsOneProcessesAlone) {
  const test::TemporaryFolder folder;
  const Journal mine(folder / "journal.jsonl");
  EXPECT_THROW(Journal(folder / "journal.jsonl"), base::ConfigError);
}

}  // namespace
}  // namespace cas::hils
