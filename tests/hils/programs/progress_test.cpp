// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/progress.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "hils/programs/batch_progress.hpp"

namespace cas::hils {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kColumns = 79;  // of a terminal that is 80 wide

std::string line_of(const FlightStep& step, const VehicleReport& vehicle,
                    const std::string& stream = {}, std::size_t columns = kColumns) {
  return progress_line(base::SimTime(milliseconds(12'340)), FlightPlan({step}), vehicle,
                       pace_words(1.0, 0), stream, columns);
}

FlightStep measured_hold() {
  return {.kind = StepKind::kHold, .duration = seconds(30), .measure = true};
}

TEST(ProgressLine, TellsTheStepAndThatThePositionIsAnEstimate) {
  const std::string line = line_of(measured_hold(), VehicleReport{.p_N = {0.5, -12.25, -2.5}});
  EXPECT_NE(line.find("measured 12.3 of 30.0 s"), std::string::npos) << line;
  EXPECT_NE(line.find(" 1.00x  estimate x +0.50 y -12.25 z 2.50 m"), std::string::npos) << line;
}

TEST(ProgressLine, TellsOfLateStepsFirst) {
  EXPECT_EQ(pace_words(0.97, 226), "0.97x, 226 late");
  const std::string line =
      progress_line(base::SimTime(milliseconds(12'340)), FlightPlan({measured_hold()}),
                    VehicleReport{}, pace_words(0.97, 226), "up 500", 60);
  EXPECT_NE(line.find("0.97x, 226 late"), std::string::npos) << line;
}

TEST(ProgressLine, LeavesOutWhatDoesNotFit) {
  const std::string stream = "HIL_SENSOR 500.0 Hz, HIL_CONTROLS 400.0 Hz";
  EXPECT_EQ(line_of(measured_hold(), {}, stream).find("HIL_SENSOR"), std::string::npos);
  EXPECT_NE(line_of(measured_hold(), {}, stream, 160).find(stream), std::string::npos);
}

TEST(ProgressLine, CountsTheStepsWhereThereIsNoTerminal) {
  const FlightPlan plan({measured_hold(), measured_hold(), measured_hold()});
  const std::string line = plain_progress_line(base::SimTime(seconds(4)), plan, {}, "1.00x");
  EXPECT_EQ(line.find("hils: step 1 of 3, "), 0U) << line;
  EXPECT_NE(line.find("measured  4.0 of 30.0 s"), std::string::npos) << line;
}

TEST(BatchLine, TellsWhatIsDoneOfHowMuchAndHowLongYet) {
  EXPECT_EQ(batch_line("compare", 3, 20, seconds(72)), "compare: 3 of 20, 1:12, about 6:48 left");
  EXPECT_EQ(batch_line("compare", 0, 20, seconds(0)), "compare: 0 of 20, 0:00");
  EXPECT_EQ(batch_line("flights", 9, 1000, seconds(9)), "flights: 9 of 1000, 0:09");
  EXPECT_EQ(batch_line("flights", 20, 20, seconds(61)), "flights: 20 of 20, 1:01");
}

TEST(ProgressLine, NeverReachesTheLastColumn) {
  FlightStep step = measured_hold();
  step.kind = StepKind::kTrajectory;
  step.name = std::string(100, 'n');
  VehicleReport vehicle{.p_N = {-12'345.67, 12'345.67, -12'345.67}};
  EXPECT_EQ(line_of(step, vehicle).size(), kColumns);
  EXPECT_LE(line_of(measured_hold(), vehicle, "words").size(), kColumns);
}

}  // namespace
}  // namespace cas::hils
