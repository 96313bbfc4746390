// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/fleet_plan.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cas::hils {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

base::SimTime at(base::Duration since_start) { return base::SimTime(since_start); }

constexpr std::size_t kLeft = 0;
constexpr std::size_t kRight = 1;

/// Two vehicles fly `steps`.
class Fleet : public testing::Test {
 protected:
  static FleetPlan plan(const std::vector<FlightStep>& steps) {
    return {{"left", "right"}, steps, std::vector<double>(2)};
  }

  static VehicleReport hovering(double up_m) {
    VehicleReport report{.heard = true, .armed = true, .in_air = true, .has_position = true};
    report.p_N = {0, 0, -up_m};
    return report;
  }

  std::vector<VehicleReport> vehicles_{hovering(3), hovering(3)};
};

FlightStep climb(std::size_t vehicle, double up_m) {
  return {.kind = StepKind::kGoto,
          .name = "climb",
          .vehicle = vehicle,
          .timeout = seconds(10),
          .place_m = {0, 0, up_m}};
}

FlightStep hold(base::Duration duration) {
  return {.kind = StepKind::kHold, .duration = duration, .measure = true};
}

TEST_F(Fleet, BeginsAStepForAllWhenTheLastIsThroughWithTheOneBefore) {
  FleetPlan fleet = plan({{.kind = StepKind::kArm}, hold(seconds(2))});
  vehicles_[kLeft].armed = vehicles_[kRight].armed = false;
  ASSERT_EQ(fleet.update(at(seconds(0)), vehicles_).size(), 2U);
  fleet.on_outcome(kLeft, at(seconds(0)));
  fleet.on_outcome(kRight, at(seconds(0)));
  vehicles_[kLeft].armed = true;
  fleet.update(at(seconds(1)), vehicles_);
  EXPECT_EQ(fleet.phase(), "arm");
  EXPECT_EQ(fleet.leader(), kRight);
  vehicles_[kRight].armed = true;
  fleet.update(at(seconds(4)), vehicles_);
  EXPECT_EQ(fleet.phase(), "hold");
  fleet.update(at(seconds(6)), vehicles_);
  ASSERT_TRUE(fleet.ended());
  for (const std::size_t vehicle : {kLeft, kRight}) {
    const auto measured = fleet.plan(vehicle).measured();
    ASSERT_TRUE(measured);
    EXPECT_EQ(measured->begin, at(seconds(4)));
    EXPECT_EQ(measured->end, at(seconds(6)));
  }
}

TEST_F(Fleet, LetsTheOthersStandByInAStepOfOne) {
  FleetPlan fleet = plan({climb(kRight, 5), hold(seconds(1))});
  const auto commands = fleet.update(at(seconds(0)), vehicles_);
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0].vehicle, kRight);
  EXPECT_EQ(fleet.phase(), "climb");
  EXPECT_EQ(fleet.leader(), kRight);
  fleet.on_outcome(kRight, at(seconds(0)));
  vehicles_[kRight] = hovering(5);
  fleet.update(at(seconds(3)), vehicles_);
  fleet.update(at(seconds(4)), vehicles_);
  EXPECT_EQ(fleet.phase(), "hold");
  ASSERT_EQ(fleet.plan(kLeft).stages().size(), 1U);
  EXPECT_EQ(fleet.plan(kLeft).stages()[0].step.kind, StepKind::kStandBy);
  EXPECT_EQ(fleet.plan(kLeft).stages()[0].end, at(seconds(4)));
}

TEST_F(Fleet, FliesStepsOfDifferentVehiclesOneAfterTheOther) {
  FleetPlan fleet = plan({climb(kRight, 5), climb(kLeft, 4)});
  ASSERT_EQ(fleet.update(at(seconds(0)), vehicles_).size(), 1U);
  fleet.on_outcome(kRight, at(seconds(0)));
  EXPECT_TRUE(fleet.update(at(seconds(1)), vehicles_).empty());
  vehicles_[kRight] = hovering(5);
  fleet.update(at(seconds(2)), vehicles_);
  const auto commands = fleet.update(at(seconds(3)), vehicles_);
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0].vehicle, kLeft);
}

TEST_F(Fleet, DoesNotCountTheTimeOfAVehicleThatWaits) {
  FleetPlan fleet = plan({climb(kRight, 5), climb(kLeft, 4)});
  fleet.update(at(seconds(0)), vehicles_);
  fleet.on_outcome(kRight, at(seconds(0)));
  vehicles_[kRight] = hovering(5);
  fleet.update(at(milliseconds(9000)), vehicles_);
  fleet.update(at(milliseconds(9900)), vehicles_);
  fleet.update(at(milliseconds(10'000)), vehicles_);
  ASSERT_EQ(fleet.leader(), kLeft);
  fleet.on_outcome(kLeft, at(seconds(10)));
  fleet.update(at(seconds(19)), vehicles_);
  EXPECT_FALSE(fleet.ended());
  fleet.update(at(milliseconds(20'100)), vehicles_);
  EXPECT_TRUE(fleet.ended());
}

TEST_F(Fleet, EndsForAllWhenOneCannotGoOn) {
  FleetPlan fleet = plan({climb(kRight, 5)});
  fleet.update(at(seconds(0)), vehicles_);
  fleet.on_outcome(kRight, at(seconds(0)));
  fleet.update(at(seconds(11)), vehicles_);
  ASSERT_TRUE(fleet.ended());
  EXPECT_TRUE(
      fleet.failure_of(kRight)->starts_with("step 1, 'climb' (goto), was not done within 10 s: "));
  EXPECT_EQ(fleet.failure_of(kLeft), "it ended with that of right");
}

/// Stock firmware that has been armed disarms itself while it waits for another vehicle.
TEST(StockFleet, ArmsNoneBeforeAllHaveTheirPosition) {
  constexpr FirmwareHabits kStock{.arms_early = true};
  const std::vector<FlightStep> steps{{.kind = StepKind::kArm, .timeout = seconds(60)}};
  FleetPlan fleet({"iris0", "iris1"}, steps, std::vector<double>(2), kStock);
  std::vector<VehicleReport> vehicles(2, {.heard = true, .on_ground = true});
  vehicles[1].position_lack = "the GPS has no fix yet";
  EXPECT_TRUE(fleet.update(base::SimTime(seconds(0)), vehicles).empty());
  vehicles[1].position_lack.reset();
  const auto commands = fleet.update(base::SimTime(seconds(20)), vehicles);
  ASSERT_EQ(commands.size(), 2U);
  EXPECT_EQ(commands[0].step.kind, StepKind::kArm);
  EXPECT_EQ(commands[1].step.kind, StepKind::kArm);
}

}  // namespace
}  // namespace cas::hils
