// SPDX-License-Identifier: BSD-3-Clause
// PX4's simulator API over a real TCP connection, with a scripted PX4 at the other end.
#include <gtest/gtest.h>

#include "tests/firmware/px4_sitl_peer.hpp"
#include "tests/firmware/running_simulation.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

constexpr const char* kFreePort = "local: '127.0.0.1:0'";

struct ReleaseCase {
  const char* name;
  Px4Release release;
};

class Px4Sitl : public testing::TestWithParam<ReleaseCase> {};

TEST_P(Px4Sitl, TakesOffHoversAndLandsInLockstep) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {.release = GetParam().release});
  double highest_m = 0;
  ASSERT_TRUE(peer.run_until([&] { return peer.pilot().ended(); })) << peer.pilot().story();
  EXPECT_EQ(peer.pilot().stage(), Pilot::Stage::kDone) << peer.pilot().story();
  EXPECT_NEAR(peer.pilot().hover_altitude_m(), 5, 0.5);
  highest_m = peer.pilot().hover_altitude_m();
  EXPECT_GT(highest_m, 4);
  EXPECT_TRUE(peer.px4().complaints().empty()) << peer.px4().complaints().front();

  // One answer for each sample after the boot, and none missed.
  EXPECT_EQ(peer.px4().answers(), peer.px4().samples() - 40);
  const SimTruth truth = simulation.look();
  // The peer answers no more while it is looked at: on a slow machine that sample times out.
  EXPECT_LE(truth.figures.lockstep_timeouts, 1U);
  EXPECT_LT(truth.p_W.z(), 0.3) << "on the ground again";
  EXPECT_LT(truth.p_W.head<2>().norm(), 1.5);

  // The truth that it asked for right after it had connected: 200 Hz beside 250 HIL_SENSORs.
  ASSERT_TRUE(peer.px4().newest_truth());
  const auto& told = *peer.px4().newest_truth();
  EXPECT_NEAR(static_cast<double>(peer.px4().truths()),
              0.8 * static_cast<double>(peer.px4().samples()), 5);
  constexpr double kHome_mm = 488'000;
  EXPECT_NEAR(told.alt - kHome_mm, truth.p_W.z() * 1e3, 20);
  EXPECT_NEAR(told.attitude_quaternion[0], 1, 0.02) << "level, nose to the north";
}

INSTANTIATE_TEST_SUITE_P(Releases, Px4Sitl,
                         testing::Values(ReleaseCase{"V1_12", Px4Release::k1_12},
                                         ReleaseCase{"V1_16", Px4Release::k1_16}),
                         [](const auto& test) { return test.param.name; });

TEST(Px4SitlTruth, IsNotSentToOneThatHasNotAsked) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  {
    Px4SitlPeer asker(simulation.port(), {.boot_samples = 20});
    ASSERT_TRUE(asker.run_until([&] { return asker.px4().truths() > 10; }));
  }
  Px4SitlPeer peer(simulation.port(), {.asks_for_truth = false, .boot_samples = 20});
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 50; }));
  EXPECT_EQ(peer.px4().truths(), 0U) << "that one has gone";
}

TEST(Px4SitlTruth, GoesOnAfterAReset) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {.boot_samples = 20});
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 50; }));
  simulation.loop().post([&] { simulation.loop().reset(); });
  const auto before = static_cast<std::uint64_t>(peer.px4().clock().time_since_epoch().count());
  const std::uint64_t truths = peer.px4().truths();
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().truths() > truths + 200; }));
  EXPECT_GT(peer.px4().newest_truth()->time_usec * 1000, before) << "on PX4's own clock";
}

TEST(Px4SitlCommands, V112IsArmedBeforeItsPositionAndRefusesToTakeOff) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {.release = Px4Release::k1_12},
                   {.waits_for_position = false});
  ASSERT_TRUE(peer.run_until([&] { return peer.pilot().ended(); })) << peer.pilot().story();
  EXPECT_EQ(peer.pilot().stage(), Pilot::Stage::kFailed);
  EXPECT_NE(peer.pilot().failure().find("take off) was temporarily rejected"), std::string::npos)
      << peer.pilot().story();
  EXPECT_EQ(casd::position_lack(*peer.pilot().vehicle(), peer.px4().clock()),
            "the estimator has no velocity yet");
  ASSERT_TRUE(peer.run_until([&] { return !peer.pilot().vehicle()->armed(); }));
  EXPECT_TRUE(casd::complaints(*peer.pilot().vehicle(), peer.px4().clock()).empty())
      << "sensors that are healthy and not \"present\"";
}

TEST(Px4SitlCommands, V116AcceptsPosctlAndStaysInItsMode) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {.release = Px4Release::k1_16});
  ASSERT_TRUE(peer.run_until([&] { return peer.pilot().vehicle() != nullptr; }));
  const std::string before = peer.pilot().vehicle()->mode();
  std::optional<casd::Outcome> outcome;
  peer.pilot().commander().set_mode(1, "POSCTL", peer.px4().clock(),
                                    [&](const casd::Outcome& o) { outcome = o; });
  ASSERT_TRUE(peer.run_until([&] { return outcome.has_value(); }));
  EXPECT_EQ(outcome->kind, casd::OutcomeKind::kRefused);
  EXPECT_NE(outcome->message.find("was accepted, then temporarily rejected: it is in " + before),
            std::string::npos)
      << outcome->message;
}

TEST(Px4SitlBoot, IsFedAtTheWallClocksPaceUntilItAnswers) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  constexpr std::uint64_t kSamples = 96;
  Px4SitlPeer peer(simulation.port(), {.boot_samples = 1000});
  const base::RunTime start = base::steady_now();
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().samples() >= kSamples; }));
  // 96 samples at 250 Hz last 0.384 s; a busy machine only makes it longer.
  EXPECT_GE(base::steady_now() - start, std::chrono::milliseconds(250));
  EXPECT_EQ(peer.px4().answers(), 0U);
}

TEST(Px4SitlBoot, AControllerThatComesBackIsServedAgain) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  std::uint64_t last_stamp = 0;
  for (int boots = 1; boots <= 3; ++boots) {
    Px4SitlPeer peer(simulation.port(), {.boot_samples = 20});
    ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 50; })) << boots;
    const std::uint64_t stamp = peer.px4().newest_sample().time_usec;
    EXPECT_GT(stamp, last_stamp) << "the clock goes on";
    last_stamp = stamp;
    peer.disconnect();
  }
  EXPECT_NE(simulation.look().stats.find("\"connections\":3"), std::string::npos);
}

TEST(Px4SitlBoot, GoesOnByTheWallClockWhenNobodyIsConnected) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  {
    Px4SitlPeer peer(simulation.port(), {.boot_samples = 20});
    ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 10; }));
  }
  const std::uint64_t steps = simulation.look().figures.steps;
  EXPECT_TRUE(wait_until([&] { return simulation.look().figures.steps > steps + 50; }));
  EXPECT_EQ(simulation.look().figures.lockstep_timeouts, 0U);
}

TEST(Px4SitlLockstep, HoldsTheClockForASecondAndThenStepsOn) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {.boot_samples = 20});
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 50; }));
  peer.set_deaf(true);
  const base::RunTime start = base::steady_now();
  const std::uint64_t samples = peer.px4().samples();
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().samples() >= samples + 2; }));
  EXPECT_GE(base::steady_now() - start, std::chrono::milliseconds(900));
  // It answers again: nothing is left behind, the flight goes on one for one.
  peer.set_deaf(false);
  const std::uint64_t answers = peer.px4().answers();
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > answers + 100; }));
  // One or two while deaf, and few for a busy machine; a lag that stays would make a hundred.
  EXPECT_LE(simulation.look().figures.lockstep_timeouts, 10U);
}

TEST(Px4SitlLockstep, StandsStillWhilePausedAndGoesOn) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {.boot_samples = 20});
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 50; }));
  simulation.loop().post([&] { simulation.loop().pause(); });
  const std::uint64_t paused_at = [&] {
    // The peer must answer the step in progress before the loop can take the order.
    auto look = std::async(std::launch::async, [&] { return simulation.look().figures; });
    peer.run_until(
        [&] { return look.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
    const auto figures = look.get();
    EXPECT_TRUE(figures.paused);
    return figures.steps;
  }();
  EXPECT_EQ(simulation.look().figures.steps, paused_at);
  simulation.loop().post([&] { simulation.loop().resume(); });
  const std::uint64_t answers = peer.px4().answers();
  EXPECT_TRUE(peer.run_until([&] { return peer.px4().answers() > answers + 50; }));
}

TEST(Px4SitlLockstep, KeepsToTheSpeedThatIsOrdered) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort, 2.0);
  Px4SitlPeer peer(simulation.port(), {.boot_samples = 20});
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 10; }));
  const base::RunTime start = base::steady_now();
  const base::RunTime sim_start = peer.px4().clock();
  ASSERT_TRUE(
      peer.run_until([&] { return peer.px4().clock() - sim_start > std::chrono::seconds(1); }));
  // One simulated second at twice the speed; delays of a busy machine are caught up slowly.
  EXPECT_GE(base::steady_now() - start, std::chrono::milliseconds(350));
}

TEST(Px4SitlLockstep, AResetDoesNotTurnTheControllersClockBack) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {.boot_samples = 20});
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().answers() > 50; }));
  simulation.loop().post([&] { simulation.loop().reset(); });
  const std::uint64_t answers = peer.px4().answers();
  EXPECT_TRUE(peer.run_until([&] { return peer.px4().answers() > answers + 200; }));
  EXPECT_TRUE(peer.px4().complaints().empty()) << peer.px4().complaints().front();
}

}  // namespace
}  // namespace cas::test
