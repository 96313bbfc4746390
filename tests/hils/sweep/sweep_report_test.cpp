// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_report.hpp"

#include <gtest/gtest.h>

#include <string>
#include <variant>

#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

/// The rows of the table of causes.
Rows causes(SweepView& view) {
  const test::TemporaryFolder folder;
  folder.write("study.yaml", "");
  folder.write("scenario.yaml", "");
  view.sweep.path = folder.path();
  const Document report = sweep_report(view, {}, {});
  for (const Document::Block& block : report.blocks) {
    const auto* table = std::get_if<Document::Table>(&block);
    if (table != nullptr && table->caption.starts_with("Why runs did not stay up")) {
      return table->rows;
    }
  }
  return {};
}

void add(SweepView& view, double up, const std::string& incident, const std::string& unfinished) {
  RowResult& result = view.results.emplace_back();
  result.row = view.results.size();
  result.outcome = up == 1 ? RowOutcome::kPassed : RowOutcome::kFailed;
  result.incident = incident;
  result.unfinished = unfinished;
  result.figures = {up};
}

TEST(SweepReport, HasACauseForEachRunThatDidNotStayUp) {
  SweepView view;
  for (int i = 0; i < 3; ++i) add(view, 1, "", "");
  for (int i = 0; i < 4; ++i) add(view, 0, "", "takeoff");
  for (int i = 0; i < 2; ++i) add(view, 0, "flyaway", "takeoff");
  add(view, 0, "", "");
  view.sweep.table.rows.resize(view.results.size());
  const Rows rows = causes(view);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1][0].text, "not completed: takeoff");
  EXPECT_EQ(rows[1][1].text, "4");
  EXPECT_EQ(rows[2][0].text, "incident: flyaway");
  EXPECT_EQ(rows[2][1].text, "2");
  EXPECT_EQ(rows[3][0].text, "not completed");
  EXPECT_EQ(rows[3][1].text, "1");
}

TEST(SweepReport, CountsTheRareCausesTogether) {
  SweepView view;
  for (int i = 0; i < 13; ++i) add(view, 0, "", "leg" + std::to_string(i));
  view.sweep.table.rows.resize(view.results.size());
  const Rows rows = causes(view);
  ASSERT_EQ(rows.size(), 12U);
  EXPECT_EQ(rows.back()[0].text, "other causes");
  EXPECT_EQ(rows.back()[1].text, "3");
}

}  // namespace
}  // namespace cas::hils
