// SPDX-License-Identifier: BSD-3-Clause
// Words and order of a run's report.
#include "hils/report/run_report.hpp"

#include <gtest/gtest.h>

#include <regex>

#include "hils/report/experiment.hpp"
#include "tests/hils/report/run_text.hpp"

namespace cas::hils {
namespace {

Stage stage(StepKind kind, bool measure = false) {
  Stage stage;
  stage.step.kind = kind;
  stage.step.measure = measure;
  return stage;
}

RateFigures whole_rate(double hz, std::uint64_t n) {
  return {.nominal_hz = hz, .sent = n, .received = n, .received_hz = hz, .drained = true};
}

Measurement hover() {
  Measurement figures;
  figures.scenario = "hover";
  figures.over_hold = true;
  figures.virtual_clock = true;
  figures.truth_samples = 5000;
  figures.window = {10'000'000, 40'000'000};
  figures.stages = {stage(StepKind::kArm), stage(StepKind::kTakeoff), stage(StepKind::kHold, true),
                    stage(StepKind::kLand)};
  figures.rates = {whole_rate(500, 15001), whole_rate(5, 151), whole_rate(400, 12001)};
  figures.rms = RmsFigures{.x_m = 0.0532, .y_m = 0.1, .z_m = 0.05, .yaw_rad = 0, .samples = 3000};
  return figures;
}

Measurement step_response() {
  Measurement figures = hover();
  figures.scenario = "gain_tuning";
  figures.stages.back() = stage(StepKind::kLoiter);
  EXPECT_EQ(measured_part(figures), "circle");
  figures.stages.pop_back();
  figures.stages[2] = stage(StepKind::kTrajectory, true);
  figures.stages[2].step.name = "after";
  figures.stages[2].step.trajectory.shape = fcu::PatternShape::kSteps;
  figures.responses = {{.name = "after", .size = 3, .rise_s = 0.9, .overshoot_pct = -0.00001}};
  return figures;
}

Limits limits() {
  Limits limits;
  limits.lost = 0;
  limits.figures["rms_x_m"] = 0.25;
  return limits;
}

std::string html_of(const Measurement& figures) {
  return write_html(run_report(test::run_of(figures, judge(figures, limits()))));
}

std::string text_of(const Measurement& figures) {
  return test::run_text(figures, judge(figures, limits()));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Whether the text has a zero with a sign.
bool has_negative_zero(const std::string& text) {
  return std::regex_search(text, std::regex("(^|[^0-9.a-z])-0(\\.0*)?([^0-9.]|$)"));
}

TEST(RunReport, BeginsWithTheLimitsAndTheirMargins) {
  const std::string html = html_of(hover());
  EXPECT_TRUE(contains(html,
                       "<td>RMS error of the true position, x_m</td><td>0.0532 m</td>"
                       "<td>≤ 0.25 m</td><td>0.1968 m (79 %)</td><td>passed</td>"))
      << html;
  EXPECT_TRUE(contains(html, "<td>incident: crash</td><td>none</td><td>none</td>"));
  EXPECT_TRUE(contains(html, "<td>validity: account of HIL_GPS</td><td>closes</td>"));
  EXPECT_LT(html.find("Limits</p>"), html.find("Communication</h2>"));
  EXPECT_LT(html.find("RMS error of the true position, x_m"), html.find("validity: account of"));
}

TEST(RunReport, ShowsAMissedLimitInRedWithANegativeMargin) {
  Measurement figures = hover();
  figures.rms->x_m = 0.3;
  EXPECT_TRUE(contains(html_of(figures),
                       "<tr class=\"missed\"><td>RMS error of the true position, x_m</td>"
                       "<td>0.3000 m</td><td>≤ 0.25 m</td><td>-0.0500 m (-20 %)</td>"
                       "<td>missed</td>"));
}

TEST(RunReport, JudgesNoLimitOfARunThatDoesNotCount) {
  Measurement figures = hover();
  figures.rates.sensor.unexplained = 1;
  const std::string html = html_of(figures);
  EXPECT_TRUE(contains(html, "<td>0.1968 m (79 %)</td><td>not judged</td>")) << html;
  EXPECT_TRUE(contains(html, "<td>validity: account of HIL_SENSOR</td><td>1 never sent</td>"));
  EXPECT_LT(html.find("validity: account of"), html.find("RMS error of the true position, x_m"));
}

TEST(RunReport, CallsAnExperimentByItsName) {
  EXPECT_TRUE(contains(html_of(hover()), "<h1>hover, TCAS</h1>"));
  EXPECT_TRUE(contains(text_of(hover()), "\nRMS error of the hover\n"));
  EXPECT_TRUE(contains(html_of(step_response()), "<h1>gain_tuning: step responses, TCAS</h1>"));
  const std::string text = test::run_text(step_response(), judge(step_response(), limits()), true);
  EXPECT_TRUE(contains(text, "over 30.0 s of step response 'after', beside")) << text;
  EXPECT_TRUE(contains(text, "\nRMS error of the step response 'after'\n")) << text;
  EXPECT_FALSE(contains(text, "hover")) << text;
  EXPECT_FALSE(contains(text, "Table 5"));  // its rows are of a hover
}

TEST(RunReport, ShowsThePaperOnRequestAlone) {
  EXPECT_FALSE(contains(text_of(hover()), "[HILS]"));
  const std::string text = test::run_text(hover(), judge(hover(), limits()), true);
  EXPECT_TRUE(contains(text, "beside Table 4 of [HILS]")) << text;
  EXPECT_TRUE(contains(text, "RMS error of the hover, beside Table 5 of [HILS]\n")) << text;
}

TEST(RunReport, EndsOnATerminalWithLimitsAndVerdict) {
  const std::string text = text_of(hover());
  const std::size_t limits = text.find("\n== Limits ==\n");
  const std::size_t verdict = text.find("\nPASSED: hover, TCAS");
  ASSERT_NE(limits, std::string::npos) << text;
  EXPECT_LT(text.find("== Flight =="), limits);
  EXPECT_LT(limits, verdict);
  EXPECT_EQ(text.find("\n\n", verdict), std::string::npos) << "nothing follows";
  EXPECT_TRUE(contains(text, "RMS error of the true position, x_m"));
  EXPECT_FALSE(contains(text, "incident: crash")) << "that did not happen";
}

TEST(RunReport, NamesTheFaultsOfAFlight) {
  using std::chrono::seconds;
  Measurement figures = hover();
  figures.faults = {
      {.name = "gps lost", .begin = base::SimTime(seconds(12)), .end = base::SimTime(seconds(15))},
      {.name = "motor 2 off", .begin = base::SimTime(seconds(20)), .end = {}}};
  figures.never_began = {{.name = "line cut", .by_time = false}};
  EXPECT_TRUE(contains(text_of(figures),
                       "Faults\n"
                       "Fault        begin s  end s\n"
                       "gps lost       12.00  15.00\n"
                       "motor 2 off    20.00      -\n"
                       "line cut       never      -\n"))
      << text_of(figures);
  EXPECT_FALSE(contains(text_of(hover()), "Fault"));
}

TEST(RunReport, HasNoNegativeZero) {
  Measurement figures = step_response();
  figures.rates.gps.error_pct = -0.00002;
  figures.rms->yaw_rad = -0.0;
  figures.sensor_to_control = {.count = 9, .p50 = -0.4, .p99 = -0.1, .max = 0.3};
  EXPECT_FALSE(has_negative_zero(text_of(figures))) << text_of(figures);
  EXPECT_FALSE(has_negative_zero(html_of(figures))) << html_of(figures);
}

TEST(RunReport, ExplainsANegativeDelay) {
  constexpr const char* kNote = "A negative delay is none: ";
  Measurement figures = hover();
  figures.controls_downlink = {.count = 9, .p50 = -0.4, .p99 = 3, .max = 4};
  EXPECT_FALSE(contains(text_of(figures), kNote));  // it is written as 0
  figures.controls_downlink.p50 = -12;
  EXPECT_TRUE(contains(text_of(figures), kNote));
  figures = hover();
  figures.paths.resize(1);
  figures.paths[0].hops.resize(1);
  EXPECT_FALSE(contains(html_of(figures), kNote));
  figures.paths[0].hops[0].delay = {.count = 9, .p50 = -12, .p99 = 3, .max = 4};
  EXPECT_TRUE(contains(html_of(figures), kNote));
  EXPECT_FALSE(contains(text_of(figures), kNote));  // it has no table of hops
}

TEST(Experiment, IsNamedByItsSteps) {
  Measurement figures = hover();
  EXPECT_EQ(experiment_of(figures), "hover");
  figures.stages.push_back(stage(StepKind::kGoto));
  EXPECT_EQ(experiment_of(figures), "flight from place to place");
  EXPECT_EQ(measured_part(figures), "hold");
  EXPECT_TRUE(measures_station_keeping(figures));
  figures.stages[2] = stage(StepKind::kTrajectory, true);
  figures.stages[2].step.trajectory.shape = fcu::PatternShape::kFigureEight;
  EXPECT_EQ(experiment_of(figures), "figure eight");
  EXPECT_FALSE(measures_station_keeping(figures));
  figures.faults.resize(1);
  EXPECT_EQ(experiment_of(figures), "figure eight with faults");
  figures.over_hold = false;
  EXPECT_EQ(measured_part(figures), "whole flight");
}

}  // namespace
}  // namespace cas::hils
