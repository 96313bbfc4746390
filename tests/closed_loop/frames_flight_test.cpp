// SPDX-License-Identifier: BSD-3-Clause
// The shipped airframes other than the paper's, flown by their scenarios: hover, a step and back, 8
// m/s of wind; and a hexarotor that loses a rotor.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "hils/scenario/scenario.hpp"
#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/support/paths.hpp"

namespace cas::hils {
namespace {

using test::Flight;

Scenario shipped(const std::string& name) {
  return Scenario::load(cas::test::source_dir() + "/config/scenarios/" + name + ".yaml");
}

class ShippedFrame : public testing::TestWithParam<const char*> {};

TEST_P(ShippedFrame, HoversStepsAndStandsAgainstWind) {
  const Flight flight(shipped(GetParam()), 1, GetParam());
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
  // As STATUSTEXT has it in the flight's log.
  EXPECT_EQ(flight.log().find("lost: flying on"), std::string::npos) << "no rotor is lost";
  EXPECT_EQ(flight.log().find("lost: the others"), std::string::npos) << "no rotor is lost";
}

INSTANTIATE_TEST_SUITE_P(All, ShippedFrame,
                         testing::Values("quad_plus", "quad_h", "hexa_x", "hexa_tilt", "octo_x",
                                         "y6", "x8", "tri"),
                         [](const auto& test) { return std::string(test.param); });

class LostRotorOfHexa : public testing::TestWithParam<int> {};

TEST_P(LostRotorOfHexa, IsFoundAndFlownWithout) {
  Scenario scenario = shipped("hexa_lost");
  const std::string number = std::to_string(GetParam());
  scenario.plugins = base::ConfigNode::parse(
                         "[{plugin: fault, faults: [{name: gone, when: phase == five, rotor: "
                         "{number: " +
                         number + ", stop: true}}]}]")
                         .items();
  scenario.faults = {};
  const Flight flight(scenario, 1, "lost" + number);
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
  EXPECT_NE(flight.log().find("Rotor " + number + " lost: flying on without it"),
            std::string::npos);
  EXPECT_NE(flight.log().find("Heading given up"), std::string::npos);
  for (const double r_rad_s : flight.truth("r_rad_s")) {
    ASSERT_LT(std::abs(r_rad_s), 1.2) << "turning is damped";
  }
}

INSTANTIATE_TEST_SUITE_P(Each, LostRotorOfHexa, testing::Range(1, 7));

}  // namespace
}  // namespace cas::hils
