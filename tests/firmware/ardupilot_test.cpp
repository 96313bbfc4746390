// SPDX-License-Identifier: BSD-3-Clause
// ArduPilot's JSON interface over a real UDP socket, with a scripted ArduCopter at the other end.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/terrain_data.hpp"
#include "mavlink/common/terrain_request.hpp"
#include "tests/firmware/ardupilot_peer.hpp"
#include "tests/firmware/running_simulation.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

namespace mv = mavlink::common;

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

/// Of config/terrain/island.tif, whose samples are 31 m apart: between them it is up to 0.4 m off.
double island_m(double north_m, double east_m) {
  return 20 + 20 * (1 - std::cos(2 * M_PI * north_m / 500)) +
         6 * (1 - std::cos(2 * M_PI * east_m / 700));
}

/// What ArduPilot asks for: 8 x 7 grids of 4 x 4 heights, 30 m apart, from 300 m south and west of
/// home.
mv::TerrainRequest request_about_home() {
  return {.lat = 299'973'050, .lon = -400'031'119, .grid_spacing = 30, .mask = (1ULL << 56U) - 1};
}

std::vector<std::uint8_t> packet_of(const mv::TerrainRequest& request) {
  std::array<std::uint8_t, mav::kMaxPacketBytes> packet;
  const std::size_t size = mav::encode(request, {1, 1}, 0, packet);
  return {packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size)};
}

TEST(ArdupilotCompanion, GetsTheTerrainThatItAsksFor) {
  UdpPeer casd;
  UdpPeer stranger;
  PacketStream said;
  RunningSimulation simulation("ardupilot_terrain.yaml", "ardupilot_json",
                               std::string(kFreePort) + "\ncompanion: '" + casd.endpoint() + "'\n");
  ArdupilotPeer ardupilot(simulation.port());
  const auto hears = [&](std::uint32_t message, std::size_t count) {
    return ardupilot.run_until([&] {
      casd.read(said);
      return said.count(message) >= count;
    });
  };
  ASSERT_TRUE(hears(mv::Heartbeat::kId, 1)) << "by which casd knows where to send requests";
  casd.set_remote(casd.newest_sender());
  stranger.set_remote(casd.newest_sender());
  stranger.send(packet_of(request_about_home()));
  ASSERT_TRUE(hears(mv::Heartbeat::kId, 3));
  EXPECT_EQ(said.count(mv::TerrainData::kId), 0U) << "to a stranger";

  casd.send(packet_of(request_about_home()));
  ASSERT_TRUE(hears(mv::TerrainData::kId, 56));
  constexpr double kOff_m = 1.1;  // whole metres, samples, and the sphere's degree
  for (const PacketStream::Packet& packet : said.packets()) {
    const auto grid = mav::decode<mv::TerrainData>(packet.view());
    if (!grid) continue;
    for (int i = 0; i < 16; ++i) {
      const double north_m = -300 + 30 * (grid->gridbit / 8 * 4 + i / 4);
      const double east_m = -300 + 30 * (grid->gridbit % 8 * 4 + i % 4);
      ASSERT_NEAR(grid->data[static_cast<std::size_t>(i)], island_m(north_m, east_m), kOff_m)
          << north_m << " " << east_m;
    }
  }
  const std::string stats = simulation.look().stats;
  EXPECT_EQ(figure(stats, "terrain_requests"), 1U) << stats;
  EXPECT_EQ(figure(stats, "grids"), 56U);
}

}  // namespace
}  // namespace cas::test
