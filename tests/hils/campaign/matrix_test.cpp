// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/matrix.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "hils/campaign/campaign_report.hpp"
#include "hils/report/plot.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using testing::HasSubstr;
using testing::Not;

/// gps_lost and baro_door in two phases, two seeds each; both must stay up.
Campaign campaign() {
  const FailureCatalogue catalogue = FailureCatalogue::shipped();
  Campaign campaign;
  campaign.name = "c&d";
  campaign.phases = {{"hover", "phase == hover"}, {"cruise", "phase == cruise"}};
  campaign.seeds = {1, 2};
  for (const char* name : {"gps_lost", "baro_door", "casd_reloaded"}) {
    CampaignFailure failure{.name = name, .failure = *catalogue.find(name)};
    for (const CampaignPhase& phase : campaign.phases) {
      failure.expected[phase.name] = {{.kind = Expectation::Kind::kStaysUp}};
    }
    campaign.failures.push_back(std::move(failure));
  }
  campaign.failures.back().obstacle = "needs casd as a program";
  return campaign;
}

RowResult row(std::size_t number, bool up, std::optional<double> detected_s = 0.5) {
  RowResult result{.row = number,
                   .outcome = up ? RowOutcome::kPassed : RowOutcome::kFailed,
                   .run_sha256 = "run " + std::to_string(number)};
  result.strike = StrikeResponse{.strike_s = 20,
                                 .detected_s = detected_s,
                                 .detected_by = "'<b>'",
                                 .completed = up,
                                 .farthest_m = static_cast<double>(number)};
  if (!up) {
    result.strike->incident = IncidentKind::kCrash;
    result.strike->crashed = true;
  }
  return result;
}

std::string text_of(const CampaignMatrix& matrix) {
  return write_text(campaign_report(matrix, "nowhere"));
}

/// The last two are those without a failure.
std::vector<RowResult> all_up() {
  std::vector<RowResult> rows;
  for (std::size_t i = 1; i <= 10; ++i) rows.push_back(row(i, true));
  return rows;
}

TEST(CampaignMatrix, AllAsExpectedEndsWithZero) {
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), all_up());
  EXPECT_EQ(matrix.cells.size(), 4U);
  EXPECT_EQ(matrix.exit_code(), 0);
  EXPECT_EQ(matrix.count(CellState::kAsExpected), 4U);
  EXPECT_EQ(matrix.find(2, 0), nullptr) << "casd_reloaded is not flown";
  EXPECT_THAT(text_of(matrix), HasSubstr("casd_reloaded: not flown"));
}

TEST(CampaignMatrix, OneFlightOfManyTurnsItsCellAndTheExitCodeRed) {
  std::vector<RowResult> rows = all_up();
  rows[3] = row(4, false, std::nullopt);  // gps_lost, cruise, seed 2
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.exit_code(), 1);
  const CellResult& cell = *matrix.find(0, 1);
  EXPECT_EQ(cell.state(), CellState::kMissed);
  EXPECT_EQ(cell.as_expected(), 1U);
  EXPECT_EQ(cell.shown().row, 4U);
  EXPECT_FALSE(cell.detected_s()) << "one of the seeds was not detected";
  EXPECT_EQ(cell.farthest_m(), 4);
  EXPECT_EQ(matrix.find(0, 0)->state(), CellState::kAsExpected);
  EXPECT_EQ(matrix.find(0, 0)->detected_s(), 0.5);
  const std::string text = text_of(matrix);
  EXPECT_THAT(text, HasSubstr("MISSED 1/2"));
  EXPECT_TRUE(std::regex_search(
      text, std::regex("gps_lost +cruise +missed .*  seed 2: stays up: incident: crash")))
      << text;
  const std::string junit = campaign_junit(matrix);
  EXPECT_THAT(junit, HasSubstr("tests=\"5\" failures=\"1\" errors=\"0\" skipped=\"1\""));
  EXPECT_THAT(junit, HasSubstr("hils.campaign.c&amp;d.gps_lost\" name=\"cruise\""));
}

TEST(CampaignMatrix, WithoutAVerdictItEndsWithThreeUnlessACellMissed) {
  std::vector<RowResult> rows = all_up();
  rows[0] = row_without_figures(RowOutcome::kHung, "no result after 9 s");
  rows[0].row = 1;
  rows[4].strike.reset();  // the failure never struck
  rows[7] = RowResult{};   // not flown
  CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.exit_code(), 3);
  EXPECT_EQ(matrix.count(CellState::kNoVerdict), 3U);
  EXPECT_THAT(matrix.find(0, 0)->shown().no_verdict, HasSubstr("no result after 9 s"));
  EXPECT_THAT(matrix.find(1, 0)->shown().no_verdict, HasSubstr("never acted"));
  EXPECT_THAT(matrix.find(1, 1)->shown().no_verdict, HasSubstr("not been flown"));
  rows[2] = row(3, false);
  matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.exit_code(), 1);
}

TEST(CampaignMatrix, AStrikeAfterTheFlightHasNoVerdictAndNoFigures) {
  std::vector<RowResult> rows = all_up();
  rows[0].strike->no_verdict = rows[1].strike->no_verdict =
      "never acted: it struck after the flight";
  rows[2].strike->no_verdict = "never acted: it struck after the flight";
  rows[3] = row(4, false);
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.find(0, 0)->state(), CellState::kNoVerdict);
  EXPECT_EQ(matrix.find(0, 0)->shown().no_verdict, "never acted: it struck after the flight");
  const auto json = nlohmann::json::parse(campaign_json(matrix));
  EXPECT_TRUE(json["cells"][0]["farthest_m"].is_null());
  EXPECT_EQ(json["cells"][1]["farthest_m"], 4);
  const std::string text = text_of(matrix);
  EXPECT_THAT(text, HasSubstr("MISSED 1/2")) << "one missed, one has no verdict: " << text;
  EXPECT_THAT(text, HasSubstr("; not flown: 1"));
}

TEST(CampaignMatrix, AFlightLikeThatWithoutAFailureHasNoVerdict) {
  std::vector<RowResult> rows = all_up();
  rows[0].run_sha256 = rows[8].run_sha256;  // gps_lost, hover, seed 1
  rows[3].run_sha256 = rows[8].run_sha256;  // of another seed
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.find(0, 0)->shown().no_verdict.find("never acted"), 0U);
  EXPECT_EQ(matrix.count(CellState::kNoVerdict), 1U);
  EXPECT_EQ(matrix.exit_code(), 3);
}

TEST(CampaignMatrix, InRealTimeNoFlightIsLikeAnother) {
  Campaign on_board = campaign();
  on_board.controllers = {"bench1"};
  std::erase_if(on_board.failures, [](const CampaignFailure& each) {
    return each.failure.needs != FailureNeeds::kNothing;
  });
  std::vector<RowResult> rows = all_up();
  for (RowResult& each : rows) each.run_sha256.clear();
  CampaignMatrix matrix = CampaignMatrix::of(on_board, rows);
  EXPECT_EQ(matrix.count(CellState::kAsExpected), 4U);
  EXPECT_EQ(matrix.exit_code(), 0);
  matrix.stopped = "board 'a' is not there";
  EXPECT_EQ(matrix.exit_code(), 3);
  EXPECT_THAT(text_of(matrix), HasSubstr("ended early: board 'a' is not there"));
  EXPECT_THAT(campaign_junit(matrix), HasSubstr("name=\"board\" time=\"0\"><error"));
}

TEST(CampaignMatrix, WithoutAFlightToCompareWithThereIsNoVerdict) {
  std::vector<RowResult> rows = all_up();
  rows[9] = row_without_figures(RowOutcome::kDied, "ended by signal 9");
  rows[9].row = 10;
  CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.exit_code(), 3);
  EXPECT_EQ(matrix.count(CellState::kNoVerdict), 4U);
  EXPECT_EQ(matrix.find(0, 0)->as_expected(), 1U) << "seed 1 can be compared";
  EXPECT_THAT(matrix.find(0, 0)->shown().no_verdict, HasSubstr("is not known"));
  EXPECT_THAT(text_of(matrix), HasSubstr("without a failure, seed 2: died"));

  Campaign unrecorded = campaign();
  for (CampaignFailure& each : unrecorded.failures) {
    if (each.failure.needs == FailureNeeds::kNothing) each.failure.unrecorded = true;
  }
  matrix = CampaignMatrix::of(unrecorded, rows);
  EXPECT_EQ(matrix.count(CellState::kAsExpected), 4U);
  EXPECT_EQ(matrix.exit_code(), 3);
}

TEST(CampaignMatrix, AFlightThatFailsByItselfIsNoPass) {
  std::vector<RowResult> rows = all_up();
  rows[9] = row(10, false);
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.count(CellState::kAsExpected), 4U);
  EXPECT_EQ(matrix.exit_code(), 3);
  EXPECT_THAT(text_of(matrix), HasSubstr("without a failure, seed 2: failed"));
}

TEST(CampaignMatrix, AFlightWithoutAFailureThatWasNotFlownIsSaid) {
  std::vector<RowResult> rows = all_up();
  rows.pop_back();
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  EXPECT_EQ(matrix.count(CellState::kNoVerdict), 4U);
  EXPECT_EQ(matrix.exit_code(), 3);
  EXPECT_THAT(text_of(matrix), HasSubstr("without a failure, seed 2: it has not been flown"));
}

TEST(CampaignMatrix, AnotherFlightWhenFlownAgainIsSaid) {
  CampaignMatrix matrix = CampaignMatrix::of(campaign(), all_up());
  EXPECT_EQ(matrix.exit_code(), 0);
  matrix.flown_otherwise = {3};
  EXPECT_EQ(matrix.exit_code(), 3);
  EXPECT_THAT(text_of(matrix), HasSubstr("row 3: another flight when it was flown again"));
}

TEST(CampaignReport, LinksTheReplaysThatAreThereAndEscapesWhatVehiclesSay) {
  const test::TemporaryFolder folder;
  folder.write("again/row_1/replay.html", "");
  folder.write("again/row_3/report.html", "");
  const std::string page =
      write_html(campaign_report(CampaignMatrix::of(campaign(), all_up()), folder / "again"));
  EXPECT_THAT(page, HasSubstr("href=\"again/row_1/replay.html\""));
  EXPECT_THAT(page, HasSubstr("href=\"again/row_3/report.html\""));
  EXPECT_THAT(page, Not(HasSubstr("again/row_5")));
  EXPECT_THAT(page, Not(HasSubstr("<b>")));
  EXPECT_EQ(escape_xml("a\x1b[31m<"), "a?[31m&lt;") << "XML has no control characters";
}

TEST(CampaignReport, HasTheWarningsOfAllFlights) {
  std::vector<RowResult> rows = all_up();
  rows[0].warnings = rows[9].warnings = {"a mass of 1 g"};
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  const std::string sentence = "warning in 2 of 10 flights: a mass of 1 g";
  EXPECT_THAT(text_of(matrix), HasSubstr(sentence));
  EXPECT_THAT(campaign_junit(matrix), HasSubstr(sentence));
  EXPECT_EQ(nlohmann::json::parse(campaign_json(matrix))["warnings"],
            nlohmann::json::parse(R"([{"warning": "a mass of 1 g", "flights": 2}])"));
}

TEST(CampaignReport, CountsTheFlightsWithoutAFailure) {
  std::vector<RowResult> rows = all_up();
  EXPECT_THAT(text_of(CampaignMatrix::of(campaign(), rows)),
              HasSubstr("; 8 flights with a failure and 2 without"));
  rows.pop_back();
  EXPECT_THAT(text_of(CampaignMatrix::of(campaign(), rows)),
              HasSubstr("; 8 flights with a failure and 1 without"));
}

TEST(CampaignReport, NamesTheFailuresThatWereLeftOut) {
  Campaign chosen = campaign();
  chosen.left_out = {"heavy", "l&m"};
  const CampaignMatrix matrix = CampaignMatrix::of(chosen, all_up());
  EXPECT_THAT(text_of(matrix), HasSubstr("left out by --only: heavy, l&m\n"));
  EXPECT_EQ(nlohmann::json::parse(campaign_json(matrix))["left_out"].size(), 2U);
  const std::string junit = campaign_junit(matrix);
  EXPECT_THAT(junit, HasSubstr("tests=\"7\" failures=\"0\" errors=\"0\" skipped=\"3\""));
  EXPECT_THAT(
      junit, HasSubstr(".l&amp;m\" name=\"all phases\" time=\"0\"><skipped message=\"left out by"));
}

TEST(CampaignReport, HasEachFlightInTheTables) {
  std::vector<RowResult> rows = all_up();
  rows[3] = row(4, false, std::nullopt);
  const CampaignMatrix matrix = CampaignMatrix::of(campaign(), rows);
  const auto json = nlohmann::json::parse(campaign_json(matrix));
  EXPECT_EQ(json["cells_missed"], 1);
  EXPECT_EQ(json["not_flown"][0], "casd_reloaded");
  EXPECT_EQ(json["cells"][1]["verdict"], "missed");
  EXPECT_EQ(json["cells"][1]["flights"][1]["row"], 4);
  EXPECT_TRUE(json["cells"][1]["flights"][1]["detected_s"].is_null());
  const std::string csv = campaign_csv(matrix);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 9);
  EXPECT_THAT(csv, HasSubstr("4,gps_lost,cruise,2,missed,20,,"));
}

}  // namespace
}  // namespace cas::hils
