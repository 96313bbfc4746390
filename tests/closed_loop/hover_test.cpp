// SPDX-License-Identifier: BSD-3-Clause
// Whole flights on the virtual clock: simulator, router, line, controller and ground station.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "tests/closed_loop/flight_fixture.hpp"

namespace cas::hils {
namespace {

using test::Flight;
using test::hover;

/// The hover flown once for all tests that look at one flight.
class Hover : public testing::Test {
 protected:
  static void SetUpTestSuite() { flight_ = new Flight(hover(), 1, "hover"); }
  static void TearDownTestSuite() {
    delete flight_;
    flight_ = nullptr;
  }
  static const Measurement& figures() { return flight_->figures(); }
  static inline const Flight* flight_ = nullptr;
};

TEST_F(Hover, KeepsTheLimitsOfItsScenario) {
  EXPECT_TRUE(flight_->verdict().passed) << flight_->text();
}

TEST_F(Hover, LosesNoPacketAndKeepsTheRatesExactly) {
  const StreamFigures& rates = figures().rates;
  // Both ends of the 30 s window may hold a packet.
  EXPECT_NEAR(static_cast<double>(rates.sensor.sent), 15000, 1) << flight_->text();
  EXPECT_NEAR(static_cast<double>(rates.gps.sent), 150, 1);
  EXPECT_NEAR(static_cast<double>(rates.controls.sent), 12000, 1);
  EXPECT_EQ(rates.sensor.lost + rates.gps.lost + rates.controls.lost, 0U);
  EXPECT_NEAR(rates.sensor.received_hz, 500, 0.05);
  EXPECT_NEAR(rates.gps.received_hz, 5, 0.005);
  EXPECT_NEAR(rates.controls.received_hz, 400, 0.05);
}

TEST_F(Hover, TakesAtLeastTheTimeOnTheWire) {
  // A control of 54 bytes after a sensor of 70 or more, ten bits a byte at 921 600 baud.
  constexpr double kWireUs = (70 + 54) * 10 / 0.9216;
  EXPECT_GT(figures().sensor_to_control.p50, kWireUs);
  EXPECT_LT(figures().sensor_to_control.p99, 4 * kWireUs);
}

TEST_F(Hover, LandsAndDisarms) {
  ASSERT_FALSE(figures().stages.empty());
  EXPECT_EQ(figures().stages.back().step.kind, StepKind::kDisarm);
  EXPECT_FALSE(figures().flight_failure);
}

TEST_F(Hover, IsTheSameToTheByteForTheSameSeed) {
  const Flight again(hover(), 1, "again");
  EXPECT_TRUE(flight_->truth() == again.truth());
  EXPECT_TRUE(flight_->log() == again.log());
}

TEST_F(Hover, IsAnotherFlightForAnotherSeed) {
  const Flight other(hover(), 2, "other");
  EXPECT_TRUE(other.verdict().passed) << other.text();
  EXPECT_FALSE(flight_->truth() == other.truth());
  EXPECT_FALSE(flight_->log() == other.log());
}

TEST(Return, LandsWhereTheVehicleWasArmed) {
  Scenario scenario = hover();
  const auto land = std::ranges::find(scenario.steps, StepKind::kLand, &FlightStep::kind);
  ASSERT_NE(land, scenario.steps.end());
  *land = {.kind = StepKind::kRtl, .timeout = std::chrono::minutes(3)};
  scenario.steps.insert(land, {.kind = StepKind::kGoto, .place_m = {6, 4, 2.5}});
  const Flight flight(scenario, 1, "return");
  EXPECT_FALSE(flight.figures().flight_failure) << *flight.figures().flight_failure;
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
}

}  // namespace
}  // namespace cas::hils
