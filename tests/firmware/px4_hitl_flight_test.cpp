// SPDX-License-Identifier: BSD-3-Clause
// Whole flights of PX4 in HITL mode, in real time.
#include <gtest/gtest.h>

#include "tests/firmware/px4_hitl_fixture.hpp"

namespace cas::test {
namespace {

class Px4HitlFlight : public testing::TestWithParam<Px4Release> {};

TEST_P(Px4HitlFlight, TakesOffHoversAndLands) {
  Px4HitlFixture hitl({.release = GetParam(), .mode = Px4Mode::kHitl});
  ASSERT_TRUE(hitl.run_until([&] { return hitl.pilot().ended(); }, std::chrono::seconds(120)))
      << hitl.pilot().story();
  EXPECT_EQ(hitl.pilot().stage(), Pilot::Stage::kDone) << hitl.pilot().story();
  EXPECT_NEAR(hitl.pilot().hover_altitude_m(), 5, 0.7);
  EXPECT_TRUE(hitl.px4().complaints().empty()) << hitl.px4().complaints().front();
  // At most 200 a second.
  EXPECT_LE(static_cast<double>(hitl.px4().answers()),
            200.5 * base::to_seconds(hitl.now().time_since_epoch()) + 1);
  EXPECT_LT(hitl.simulation().look().p_W.z(), 0.3) << "on the ground again";
}

INSTANTIATE_TEST_SUITE_P(Releases, Px4HitlFlight,
                         testing::Values(Px4Release::k1_12, Px4Release::k1_16),
                         [](const auto& test) {
                           return test.param == Px4Release::k1_12 ? "V1_12" : "V1_16";
                         });

}  // namespace
}  // namespace cas::test
