// SPDX-License-Identifier: BSD-3-Clause
// Stock PX4 in HITL mode on a serial line behind casd, in real time.
#include <gtest/gtest.h>

#include "tests/firmware/px4_hitl_fixture.hpp"

namespace cas::test {
namespace {

struct LineCase {
  const char* name;
  Px4Release release;
  unsigned baud;
};

class Px4HitlLine : public testing::TestWithParam<LineCase> {};

TEST_P(Px4HitlLine, SamplesFlowAndDisarmedOutputsMoveNothing) {
  Px4HitlFixture hitl({.release = GetParam().release, .mode = Px4Mode::kHitl}, GetParam().baud);
  ASSERT_TRUE(hitl.run_until([&] { return hitl.px4().samples() > 250; }));
  for (const std::string& complaint : hitl.px4().complaints()) {
    EXPECT_EQ(complaint, "BARO #0 failed: TIMEOUT!") << "all that a busy machine may cause";
  }

  // PX4's own clock and -0.1 on its motors while disarmed move nothing.
  const SimTruth truth = hitl.simulation().look();
  EXPECT_NE(truth.stats.find("\"HIL_ACTUATOR_CONTROLS\":"), std::string::npos) << truth.stats;
  EXPECT_LT(truth.p_W.z(), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Lines, Px4HitlLine,
                         testing::Values(LineCase{"Usb12", Px4Release::k1_12, 0},
                                         LineCase{"Baud921600With16", Px4Release::k1_16, 921600}),
                         [](const auto& test) { return test.param.name; });

TEST(Px4Hitl, AStreamThatEndsIsNoticedAndComesBack) {
  Px4HitlFixture hitl({.mode = Px4Mode::kHitl});
  ASSERT_TRUE(hitl.run_until([&] { return hitl.px4().samples() > 50; }));
  auto& loop = hitl.simulation().loop();
  loop.post([&] { loop.pause(); });
  ASSERT_TRUE(hitl.run_until([&] { return !hitl.px4().complaints().empty(); }));
  EXPECT_EQ(hitl.px4().complaints().front(), "BARO #0 failed: TIMEOUT!");
  loop.post([&] { loop.resume(); });
  const std::uint64_t samples = hitl.px4().samples();
  EXPECT_TRUE(hitl.run_until([&] { return hitl.px4().samples() > samples + 50; }));
}

}  // namespace
}  // namespace cas::test
