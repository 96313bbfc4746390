// SPDX-License-Identifier: BSD-3-Clause
// ArduPilot's JSON interface over a real UDP socket, with a scripted ArduCopter at the other end.
#include <gtest/gtest.h>

#include "tests/firmware/ardupilot_peer.hpp"
#include "tests/firmware/running_simulation.hpp"

namespace cas::test {
namespace {

constexpr const char* kFreePort = "local: '127.0.0.1:0'";
constexpr base::Duration kSoon = std::chrono::seconds(10);  // deadline, not a wait

std::uint64_t figure(const std::string& stats, const std::string& name) {
  const std::string key = "\"" + name + "\":";
  return std::stoull(stats.substr(stats.find(key) + key.size()));
}

TEST(Ardupilot, IsArmedBeforeItsPositionAndRefusesGuided) {
  RunningSimulation simulation("ardupilot.yaml", "ardupilot_json", kFreePort);
  ArdupilotPeer peer(simulation.port(), {.position_after = std::chrono::seconds(20)},
                     {.waits_for_position = false});
  ASSERT_TRUE(peer.run_until([&] { return peer.pilot().ended(); })) << peer.pilot().story();
  EXPECT_EQ(peer.pilot().stage(), Pilot::Stage::kFailed);
  EXPECT_NE(peer.pilot().failure().find("MAV_CMD 176 (set mode) failed"), std::string::npos)
      << peer.pilot().story();
  const auto lack = [&] {
    return casd::position_lack(*peer.pilot().vehicle(), peer.ardupilot().clock());
  };
  ASSERT_TRUE(peer.run_until([&] { return lack() == "the estimator has no velocity yet"; }))
      << lack();
}

TEST(Ardupilot, TakesOffHoversAndLandsInLockstep) {
  RunningSimulation simulation("ardupilot.yaml", "ardupilot_json", kFreePort);
  ArdupilotPeer peer(simulation.port(), {.position_after = std::chrono::seconds(8)},
                     {.hover = std::chrono::seconds(5)});
  const auto at = [&](Pilot::Stage stage) { return peer.pilot().stage() >= stage; };
  ASSERT_TRUE(peer.run_until([&] { return at(Pilot::Stage::kHover); }))
      << peer.pilot().story() << peer.ardupilot().complaint();
  // Once it hangs still: the output of the iris at rest in the air.
  const base::RunTime still = peer.ardupilot().clock() + std::chrono::seconds(3);
  ASSERT_TRUE(peer.run_until([&] { return peer.ardupilot().clock() > still; }));
  peer.ardupilot().clear_mean();
  ASSERT_TRUE(peer.run_until([&] { return at(Pilot::Stage::kLand); })) << peer.pilot().story();
  EXPECT_NEAR(peer.ardupilot().mean_pwm_us(), 1703, 15) << "hover";
  ASSERT_TRUE(peer.run_until([&] { return peer.pilot().ended(); }));
  EXPECT_EQ(peer.pilot().stage(), Pilot::Stage::kDone) << peer.pilot().story();
  EXPECT_NEAR(peer.pilot().hover_altitude_m(), 5, 0.5);
  EXPECT_EQ(peer.ardupilot().complaint(), "");
  EXPECT_EQ(peer.repeats(), 0U);

  const SimTruth truth = simulation.look();
  EXPECT_EQ(figure(truth.stats, "packets"), peer.ardupilot().frame_count());
  EXPECT_EQ(figure(truth.stats, "skipped"), 0U);
  EXPECT_LT(truth.p_W.z(), 0.3) << "on the ground again";
}

class ArdupilotLink : public testing::Test {
 protected:
  /// Sends the current packet and takes its answer in.
  std::string exchange(ArdupilotPeer& peer) {
    peer.send_packet();
    std::string text = peer.receive(kSoon);
    EXPECT_TRUE(peer.ardupilot().on_text(text)) << peer.ardupilot().complaint();
    return text;
  }

  RunningSimulation simulation_{"ardupilot.yaml", "ardupilot_json", kFreePort};
};

TEST_F(ArdupilotLink, EachPacketIsOneTwelveHundredthOfASecond) {
  ArdupilotPeer peer(simulation_.port());
  exchange(peer);
  const double first = peer.ardupilot().newest()->timestamp;
  for (int i = 0; i < 120; ++i) exchange(peer);
  EXPECT_NEAR(peer.ardupilot().newest()->timestamp - first, 0.1, 1e-6);
}

TEST_F(ArdupilotLink, ThirtyTwoChannelsAreAnsweredToo) {
  ArdupilotPeer peer(simulation_.port(), {.channels = 32});
  for (int i = 0; i < 50; ++i) exchange(peer);
  EXPECT_EQ(figure(simulation_.look().stats, "bad_packets"), 0U);
}

TEST_F(ArdupilotLink, APacketThatIsRepeatedGetsTheSameAnswerWithoutAStep) {
  ArdupilotPeer peer(simulation_.port());
  exchange(peer);
  peer.send_packet();
  const std::string answer = peer.receive(kSoon);
  peer.send_packet();  // the answer was lost on its way
  EXPECT_EQ(peer.receive(kSoon), answer);
  EXPECT_EQ(figure(simulation_.look().stats, "repeated"), 1U);
}

TEST_F(ArdupilotLink, SkippedPacketsAreCounted) {
  ArdupilotPeer peer(simulation_.port());
  exchange(peer);
  peer.ardupilot().skip_packets(3);
  exchange(peer);
  EXPECT_EQ(figure(simulation_.look().stats, "skipped"), 3U);
}

TEST_F(ArdupilotLink, AFirmwareThatStartsAnewIsAnsweredAtItsNewPort) {
  {
    ArdupilotPeer first(simulation_.port());
    for (int i = 0; i < 20; ++i) exchange(first);
  }
  ArdupilotPeer second(simulation_.port());
  for (int i = 0; i < 20; ++i) exchange(second);
  const std::string stats = simulation_.look().stats;
  EXPECT_EQ(figure(stats, "restarts"), 1U);
  EXPECT_EQ(figure(stats, "packets"), 40U);
}

TEST_F(ArdupilotLink, AResetOfTheWorldDoesNotTurnTimeBack) {
  ArdupilotPeer peer(simulation_.port());
  for (int i = 0; i < 50; ++i) exchange(peer);
  const double before = peer.ardupilot().newest()->timestamp;
  simulation_.loop().post([this] { simulation_.loop().reset(); });
  for (int i = 0; i < 50; ++i) exchange(peer);
  EXPECT_GT(peer.ardupilot().newest()->timestamp, before);
}

}  // namespace
}  // namespace cas::test
