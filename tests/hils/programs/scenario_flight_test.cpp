// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/scenario_flight.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

namespace cas::hils {
namespace {

using std::chrono::seconds;

TEST(ScenarioFlight, BeginsAtTheHeadingOfEachVehicleAndIsRecordedAsItWent) {
  Scenario scenario;
  scenario.vehicles.resize(2);
  scenario.vehicles[1].name = "iris1";
  scenario.vehicles[1].pose.yaw_deg = 0;  // its nose points east
  scenario.steps = {{.kind = StepKind::kHold, .duration = seconds(2), .measure = true}};
  Flight flight = flight_of(scenario);
  EXPECT_NEAR(flight.plan.plan(0).reference_yaw_rad(), 0, 1e-12);
  EXPECT_NEAR(flight.plan.plan(1).reference_yaw_rad(), M_PI / 2, 1e-12);

  flight.vehicles.assign(2, {.heard = true});
  flight.plan.update(base::SimTime(seconds(1)), flight.vehicles);
  RunRecord record;
  record_flight(flight, 1, base::SimTime(seconds(2)), record);
  ASSERT_TRUE(record.under_way);
  EXPECT_FALSE(record.hold);
  flight.plan.update(base::SimTime(seconds(3)), flight.vehicles);
  record_flight(flight, 1, base::SimTime(seconds(4)), record);
  EXPECT_FALSE(record.under_way);
  ASSERT_TRUE(record.hold);
  EXPECT_EQ(record.hold->end, base::SimTime(seconds(3)));
  EXPECT_EQ(record.stages.size(), 1U);
  EXPECT_EQ(record.simulated_s, 4);
}

}  // namespace
}  // namespace cas::hils
