// SPDX-License-Identifier: BSD-3-Clause
// Several vehicles of one run: one verdict, and each under its name.
#include "hils/measure/run_result.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <string>

#include "hils/report/figure_rows.hpp"
#include "hils/report/junit_report.hpp"
#include "hils/report/run_report.hpp"
#include "hils/report/summary_json.hpp"
#include "tests/hils/report/run_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using testing::HasSubstr;
using testing::Not;

VehicleResult flown(const std::string& name, Verdict verdict) {
  VehicleResult vehicle;
  vehicle.figures.scenario = "pair";
  vehicle.figures.vehicle = name;
  vehicle.figures.pace.real_time_factor = 1;
  vehicle.verdict = std::move(verdict);
  return vehicle;
}

const Verdict kPassed{.valid = true, .passed = true, .failures = {}};
const Verdict kMissed{.valid = true, .passed = false, .failures = {"5 of 9 packets were lost"}};
const Verdict kOpen{.valid = false, .passed = false, .failures = {"the account does not close"}};

RunResult together(const Verdict& left, const Verdict& right) {
  RunResult run;
  run.vehicles = {flown("left", left), flown("right", right)};
  run.verdict = judge_together(run.vehicles);
  return run;
}

TEST(SeveralResults, PassWhenEachVehiclePasses) {
  EXPECT_EQ(together(kPassed, kPassed).verdict.exit_code(), kExitPassed);
}

TEST(SeveralResults, FailWithTheNameOfWhoMissedALimit) {
  const Verdict verdict = together(kPassed, kMissed).verdict;
  EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
  ASSERT_EQ(verdict.failures.size(), 1U);
  EXPECT_EQ(verdict.failures[0], "right: 5 of 9 packets were lost");
}

TEST(SeveralResults, AreWorthNothingWhenOneAccountIsOpen) {
  EXPECT_EQ(together(kOpen, kPassed).verdict.exit_code(), kExitInvalid);
}

TEST(SeveralResults, ShowEachVehicleUnderItsName) {
  const RunResult run = together(kPassed, kMissed);
  const auto summary = nlohmann::json::parse(summary_json(run));
  ASSERT_EQ(summary.at("vehicles").size(), 2U);
  EXPECT_FALSE(summary.at("passed"));
  EXPECT_TRUE(summary.contains("cpu_s"));
  EXPECT_EQ(summary.at("vehicles")[0].at("name"), "left");
  EXPECT_TRUE(summary.at("vehicles")[0].at("passed"));
  const auto& alone = run.vehicles[1];
  EXPECT_EQ(summary.at("vehicles")[1], test::vehicle_summary(alone.figures, alone.verdict));
  const std::string text = write_text(run_lines(run));
  EXPECT_THAT(text, HasSubstr("== left: Flight =="));
  EXPECT_THAT(text, HasSubstr("== right: Flight =="));
}

TEST(SeveralResults, ShowADashForAnRmsThatWasNotMeasured) {
  using Cells = Row;
  Measurement figures;
  EXPECT_EQ(figure_cells(figures, "left", rms_keys("rms")), (Cells{"left", "-", "-", "-", "-"}));
  figures.rms = RmsFigures{.x_m = 0.25};
  EXPECT_EQ(figure_cells(figures, "left", rms_keys("rms")),
            (Cells{"left", "0.2500", "0.0000", "0.0000", "0.0000"}));
}

TEST(SeveralResults, AreASuiteEachForContinuousIntegration) {
  const std::string xml = junit_report(together(kPassed, kMissed));
  EXPECT_THAT(xml, HasSubstr("<testsuite name=\"hils.pair.tcas.left\" tests=\"1\" failures=\"0\""));
  EXPECT_THAT(xml,
              HasSubstr("<testsuite name=\"hils.pair.tcas.right\" tests=\"1\" failures=\"1\""));
}

TEST(OneResult, NamesItsWarningsInEachReport) {
  Verdict verdict = kPassed;
  verdict.warnings = {"v.urdf:3: link 'a': no body has this <inertia>; taken as a point mass"};
  RunResult run{.vehicles = {flown("iris0", verdict)}, .verdict = verdict};
  EXPECT_EQ(nlohmann::json::parse(summary_json(run)).at("warnings"),
            nlohmann::json(verdict.warnings));
  EXPECT_THAT(write_text(run_lines(run)), HasSubstr("\n  - warning: v.urdf:3: link 'a'"));
  EXPECT_THAT(junit_report(run), HasSubstr("<system-out>warning: v.urdf:3: link "));
  EXPECT_THAT(junit_report(run), Not(HasSubstr("this <inertia>"))) << "escaped";
}

TEST(SeveralResults, HaveEachWarningOnce) {
  Verdict left = kPassed;
  left.warnings = {"of the world", "of the left"};
  Verdict right = kPassed;
  right.warnings = {"of the world"};
  EXPECT_EQ(together(left, right).verdict.warnings, left.warnings);
}

TEST(SimulatorWarnings, AreTheWorldsTheVehiclesOwnAndItsPlugins) {
  const cas::test::TemporaryFolder folder;
  const auto file = folder.write("hilsim_stats.json", R"({"plugins": {
      "motor@left": {"warnings": ["of the left motor"]}, "motor@right": {"warnings": ["no"]},
      "odd@left": "text"}, "warnings": [
      {"vehicle": "", "warning": "of the world"}, {"vehicle": "right", "warning": "no"},
      {"vehicle": "left", "warning": "of the left"}]})");
  EXPECT_EQ(simulator_warnings(file, "left"),
            (std::vector<std::string>{"of the world", "of the left", "of the left motor"}));
  EXPECT_TRUE(simulator_warnings(folder / "nothing", "left").empty());
}

TEST(OneResult, ThatDoesNotCountIsAnErrorForContinuousIntegration) {
  RunResult run{.vehicles = {flown("iris0", kOpen)}, .verdict = kOpen};
  const std::string xml = junit_report(run);
  EXPECT_THAT(xml, HasSubstr("tests=\"1\" failures=\"0\" errors=\"1\""));
  EXPECT_THAT(xml, HasSubstr("<error message=\"the account does not close\"/>"));
  EXPECT_THAT(xml, HasSubstr("name=\"verdict\" time"));
  EXPECT_TRUE(write_text(run_report(run)).starts_with("INVALID: "));
  EXPECT_FALSE(nlohmann::json::parse(summary_json(run)).at("valid"));
}

/// A case keeps its name over the runs.
TEST(OneResult, HasTheSameCasesHoweverItEnds) {
  const auto cases = [](bool kept) {
    Verdict verdict = kept ? kPassed : kMissed;
    verdict.checks = {{.what = "loss", .kept = true},
                      {.what = "RMS z_m", .kept = kept, .sentence = kept ? "" : "z_m is 0.2"},
                      {.what = "settling", .judged = false}};
    RunResult run{.vehicles = {flown("iris0", verdict)}, .verdict = verdict};
    return junit_report(run);
  };
  for (const char* name : {"verdict", "loss", "RMS z_m", "settling"}) {
    const std::string attribute = "name=\"" + std::string(name) + "\"";
    EXPECT_THAT(cases(true), HasSubstr(attribute));
    EXPECT_THAT(cases(false), HasSubstr(attribute));
  }
  EXPECT_THAT(cases(true), HasSubstr("tests=\"4\" failures=\"0\" errors=\"0\" skipped=\"1\""));
  EXPECT_THAT(cases(false), HasSubstr("failures=\"2\""));
  EXPECT_THAT(cases(false), HasSubstr("<failure message=\"z_m is 0.2\"/>"));
}

TEST(OneResult, IsReportedWithoutAName) {
  RunResult run{.vehicles = {flown("iris0", kPassed)}, .verdict = kPassed};
  EXPECT_THAT(write_text(run_report(run)), Not(HasSubstr("iris0")));
  EXPECT_THAT(junit_report(run), Not(HasSubstr("iris0")));
}

}  // namespace
}  // namespace cas::hils
