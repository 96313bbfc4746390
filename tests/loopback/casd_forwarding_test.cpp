// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

std::vector<std::uint64_t> one_to(std::uint64_t last) {
  std::vector<std::uint64_t> all(last);
  std::iota(all.begin(), all.end(), std::uint64_t{1});
  return all;
}

class CasdForwarding : public testing::TestWithParam<const char*> {
 protected:
  std::string topology() const {
    return std::string("threads: ") + GetParam() + "\n" + kHilTopology;
  }
  CasdFixture fixture;
};

TEST_P(CasdForwarding, CarriesTheHilStreamsBothWaysAsTheyCame) {
  fixture.start(topology());
  constexpr std::uint64_t kPackets = 300;
  std::vector<std::vector<std::uint8_t>> sent;
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    const auto sensor = fixture.from_sim(hil_sensor(i));
    sent.emplace_back(sensor.begin(), sensor.end());
    fixture.sim.send(sensor);
    fixture.fcu.write(fixture.from_fcu(hil_controls(i)));
    // Never more on its way than the line carries within the age limit.
    ASSERT_TRUE(fixture.collect_until([&] {
      return fixture.at_fcu.count(kHilSensor) == i && fixture.at_sim.count(kHilControls) == i;
    })) << i;
  }
  EXPECT_EQ(numbers(fixture.at_fcu, kHilSensor), one_to(kPackets));
  EXPECT_EQ(numbers(fixture.at_sim, kHilControls), one_to(kPackets));
  for (std::size_t i = 0; i < sent.size(); ++i)
    EXPECT_EQ(fixture.at_fcu.packets()[i].bytes, sent[i]);
  EXPECT_EQ(fixture.at_fcu.garbage(), 0U);
  EXPECT_EQ(fixture.status("sim").rx.lost, 0U);
  // A packet counts once its write has returned, which is after the far end has it.
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.status("fcu").tx.packets == kPackets; }));
}

TEST_P(CasdForwarding, LetsOnlyWhatTheRouteAllowsPass) {
  fixture.start(topology());
  fixture.fcu.write(fixture.from_fcu(mavlink::common::Attitude{.roll = 0.1F}));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 1; }));
  EXPECT_EQ(fixture.at_sim.packets().size(), 1U);
}

TEST_P(CasdForwarding, FindsPacketsBetweenGarbageAndHalfPackets) {
  fixture.start(topology());
  const auto whole = fixture.from_fcu(hil_controls(7));
  std::vector<std::uint8_t> bytes{0xFD, 0x00, 0x55, 0xFE, 0xFD};
  bytes.insert(bytes.end(), whole.begin(), whole.begin() + 20);  // cut short
  bytes.insert(bytes.end(), whole.begin(), whole.end());
  fixture.fcu.write(bytes);
  // The next packets disprove the half packet's claim to the bytes after it.
  const auto next = fixture.from_fcu(hil_controls(8));
  for (int i = 0; i < 6; ++i) fixture.fcu.write(next);
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) >= 2; }));
  EXPECT_EQ(numbers(fixture.at_sim, kHilControls).front(), 7U);
  EXPECT_EQ(fixture.at_sim.garbage(), 0U);

  // A datagram with a half packet takes nothing from the next one.
  const auto sensor = fixture.from_sim(hil_sensor(1));
  fixture.sim.send(sensor.first(30));
  fixture.sim.send(fixture.from_sim(hil_sensor(2)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  EXPECT_EQ(numbers(fixture.at_fcu, kHilSensor).front(), 2U);
}

TEST_P(CasdForwarding, WritesTheFlightLog) {
  fixture.start(topology());
  const auto file = fixture.folder / "flight.tlog";
  casd::TlogRecording::Options options;
  options.files.folder = fixture.folder.path();
  options.files.name = "flight";
  fixture.links().tlog().start(options);
  const auto packet = fixture.from_sim(hil_sensor(1));
  fixture.sim.send(packet);
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  fixture.links().tlog().stop();
  EXPECT_EQ(std::filesystem::file_size(file), 8 + packet.size());
}

INSTANTIATE_TEST_SUITE_P(Threads, CasdForwarding,
                         testing::Values("auto", "per_link", "single", "blocking"),
                         [](const auto& test) { return std::string(test.param); });

// As QGroundControl's forwarding does to another port of the casd that it is connected to.
TEST(CasdLoop, ThroughAStationThatSendsBackWhatItGetsEnds) {
  CasdFixture fixture;
  UdpPeer station;
  UdpPeer forwards;
  fixture.start(
      "schema: 1\nlinks:\n  - {name: fcu, type: serial, device: \"$FCU\"}\n"
      "  - {name: gcs, type: udp, remote: \"" +
      station.endpoint() + "\"}\n  - {name: back, type: udp_server, local: \"127.0.0.1:0\"}\n");
  forwards.set_remote(fixture.port("back"));
  PacketStream heard;
  std::size_t forwarded = 0;
  const auto copies_dropped = [&](std::uint64_t least) {
    return fixture.collect_until([&] {
      station.read(heard);
      for (; forwarded < heard.packets().size(); ++forwarded) {
        forwards.send(heard.packets()[forwarded].bytes);
      }
      constexpr auto kDuplicate = static_cast<std::size_t>(casd::Route::Decision::kDuplicate);
      return fixture.status("back").rx.decisions[kDuplicate] >= least;
    });
  };
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(copies_dropped(1));
  constexpr std::size_t kSomeTurns = 100;
  EXPECT_LT(forwarded, kSomeTurns);
  fixture.fcu.write(fixture.from_fcu(hil_controls(2)));
  ASSERT_TRUE(copies_dropped(2));
  EXPECT_EQ(std::ranges::count(numbers(heard, kHilControls), 2U), 1);
}

TEST(CasdUdp, CountsWhatItsDestinationRefuses) {
  std::uint16_t port = 0;
  { port = UdpPeer().port(); }  // nobody is there any more
  CasdFixture fixture;
  std::string yaml = std::string(kHilTopology) + "  - {from: sim, to: gcs}\n";
  fixture.start(yaml.insert(
      yaml.find("routes:"),
      "  - {name: gcs, type: udp, remote: \"127.0.0.1:" + std::to_string(port) + "\"}\n"));
  constexpr auto kClosed = static_cast<std::size_t>(casd::DropCause::kClosed);
  for (std::uint64_t sent = 1; sent <= 5; ++sent) {
    fixture.sim.send(fixture.from_sim(hil_sensor(sent)));
    ASSERT_TRUE(fixture.collect_until([&] {
      const auto tx = fixture.status("gcs").tx;
      return tx.refused + tx.dropped[kClosed] == sent;
    })) << sent;
  }
  EXPECT_GT(fixture.status("gcs").tx.refused, 0U);
}

}  // namespace
}  // namespace cas::test
