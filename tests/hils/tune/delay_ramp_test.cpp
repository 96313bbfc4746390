// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/delay_ramp.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"

namespace cas::hils {
namespace {

DelayRamp ramp_of(const std::string& text) {
  return DelayRamp::parse(base::ConfigNode::parse(text));
}

TEST(DelayRamp, IsAListOfLineFaults) {
  EXPECT_EQ(ramp_of("{from_s: 10, every_s: 1.5, step_us: 4000, most_us: 9000}").faults(),
            "[{name: delay_1, at_s: 10, for_s: 1.5, line: {extra_delay_us: 4000}}, "
            "{name: delay_2, at_s: 11.5, for_s: 1.5, line: {extra_delay_us: 8000}}]");
}

/// The delay under which the vehicle fell has not been borne.
TEST(DelayRamp, TheMarginIsTheLastDelayThatWasBorneToItsEnd) {
  const DelayRamp ramp = ramp_of("{from_s: 10, every_s: 2, step_us: 5000, most_us: 20000}");
  EXPECT_EQ(ramp.margin_us(3), 0);
  EXPECT_EQ(ramp.margin_us(11.9), 0);
  EXPECT_EQ(ramp.margin_us(12), 5000);
  EXPECT_EQ(ramp.margin_us(15.9), 10'000);
  EXPECT_EQ(ramp.margin_us(1000), 20'000);
}

TEST(DelayRamp, HasAtLeastOneStepAndAtMost200) {
  EXPECT_THROW(ramp_of("{from_s: 1, step_us: 10, most_us: 9}"), base::ConfigError);
  EXPECT_THROW(ramp_of("{from_s: 1, step_us: 1, most_us: 201}"), base::ConfigError);
  EXPECT_THROW(ramp_of("{from_s: 1, step_us: 1}"), base::ConfigError);
}

TEST(DelayRamp, ChangesWhenTheSimulatorLooks) {
  EXPECT_THROW(ramp_of("{from_s: 1, every_s: 0.12, step_us: 1, most_us: 5}"), base::ConfigError);
  EXPECT_NO_THROW(ramp_of("{from_s: 1, every_s: 0.15, step_us: 1, most_us: 5}"));
}

}  // namespace
}  // namespace cas::hils
