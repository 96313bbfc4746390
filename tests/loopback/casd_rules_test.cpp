// SPDX-License-Identifier: BSD-3-Clause
// Groups, rates, caps, and the account of everything that did not go on.
#include <gtest/gtest.h>

#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

/// How many packets of a message a link counted under "rx", "tx" or "drop.CAUSE".
std::uint64_t counted(CasdFixture& fixture, const std::string& link, const std::string& direction,
                      std::uint32_t message) {
  std::uint64_t sum = 0;
  for (const auto& entry : fixture.links().figures().messages(base::steady_now(), link)) {
    if (to_string(entry.way) == direction && entry.id == message) sum += entry.count;
  }
  return sum;
}

TEST(CasdGroup, PassesEachPacketOnceWhicheverPathIsFirst) {
  CasdFixture fixture;
  UdpPeer path_a;
  UdpPeer path_b;
  fixture.start(R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
  - {name: a, type: udp, local: "127.0.0.1:0", group: wing}
  - {name: b, type: udp, local: "127.0.0.1:0", group: wing}
)");
  path_a.set_remote(fixture.port("a"));
  path_b.set_remote(fixture.port("b"));
  constexpr std::uint64_t kPackets = 2000;
  constexpr std::size_t kBlock = 50;  // path b brings everything this much later
  std::vector<std::vector<std::uint8_t>> late;
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    const auto packet = fixture.from_sim(hil_sensor(i));
    path_a.send(packet);
    late.emplace_back(packet.begin(), packet.end());
    if (i % kBlock != 0) continue;
    ASSERT_TRUE(fixture.collect_until([&] { return fixture.status("a").rx.packets == i; }));
    for (const auto& late_packet : late) path_b.send(late_packet);
    late.clear();
    ASSERT_TRUE(fixture.collect_until([&] { return fixture.status("b").rx.packets == i; }));
  }
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) >= kPackets; }));
  EXPECT_EQ(fixture.at_fcu.count(kHilSensor), kPackets);
  // Path a is counted just before it is routed: a packet of b may overtake there.
  EXPECT_EQ(counted(fixture, "a", "drop.duplicate", kHilSensor) +
                counted(fixture, "b", "drop.duplicate", kHilSensor),
            kPackets);
}

TEST(CasdDuplicates, ComeOnceToTheStationThatHearsTwoRadios) {
  CasdFixture fixture;
  UdpPeer radio;
  UdpPeer station;
  fixture.start(R"(schema: 1
duplicate_window_ms: 60000
commanding: {heartbeat_hz: 0, ask_on_sight: false}
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: other, type: udp, local: "127.0.0.1:0"}
  - {name: gcs, type: udp, local: "127.0.0.1:0", queue: {telemetry_max_age_ms: 60000}}
)");
  radio.set_remote(fixture.port("other"));
  station.set_remote(fixture.port("gcs"));
  mav::Encoder gcs{{255, 190}};
  station.send(gcs(mavlink::common::Heartbeat{}));  // casd knows now where it is
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.status("gcs").rx.packets == 1; }));
  constexpr std::uint64_t kPackets = 200;
  mav::Encoder vehicle{{1, 1}};
  PacketStream at_station;
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    const auto packet = vehicle(mavlink::common::Heartbeat{});
    (i % 2 == 0 ? fixture.sim : radio).send(packet);
    (i % 2 == 0 ? radio : fixture.sim).send(packet);
    station.read(at_station);
  }
  const auto dropped = [&] {
    return counted(fixture, "sim", "drop.duplicate", kHeartbeat) +
           counted(fixture, "other", "drop.duplicate", kHeartbeat);
  };
  EXPECT_TRUE(fixture.collect_until([&] {
    station.read(at_station);
    return at_station.count(kHeartbeat) >= kPackets && dropped() >= kPackets;
  })) << at_station.count(kHeartbeat)
      << " and " << dropped();
  EXPECT_EQ(at_station.count(kHeartbeat), kPackets);
  EXPECT_EQ(dropped(), kPackets);
}

TEST(CasdRates, ThinOutAMessageAndCountWhatWasLeftOut) {
  CasdFixture fixture(R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
routes:
  - {from: sim, to: fcu, rates: {HIL_SENSOR: {every: 5}, HEARTBEAT: 0.001}}
)");
  for (std::uint64_t i = 1; i <= 100; ++i) {
    fixture.sim.send(fixture.from_sim(hil_sensor(i)));
    fixture.sim.send(fixture.from_sim(mavlink::common::Heartbeat{}));
  }
  const auto left_out = [&](std::uint32_t message) {
    return counted(fixture, "sim", "drop.rate_limited", message);
  };
  EXPECT_TRUE(fixture.collect_until([&] {
    return fixture.at_fcu.count(kHilSensor) == 20 && fixture.at_fcu.count(kHeartbeat) == 1 &&
           left_out(kHilSensor) == 80 && left_out(kHeartbeat) == 99;
  })) << left_out(kHilSensor)
      << " and " << left_out(kHeartbeat);
}

TEST(CasdCap, HoldsALinkToItsBytesASecondAndCountsTheRestAsBandwidth) {
  CasdFixture fixture(R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$FCU"}
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM", max_bytes_s: 20000}
)");
  // 5000 packets of 54 bytes: 13 s at this rate, against an age limit of 25 ms.
  constexpr std::uint64_t kPackets = 5000;
  const base::RunTime begin = base::steady_now();
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    fixture.fcu.write(fixture.from_fcu(hil_controls(i)));
    if (i % 50 == 0) fixture.collect();
  }
  ASSERT_TRUE(fixture.collect_until([&] {
    return fixture.status("sim").tx.packets +
               counted(fixture, "sim", "drop.bandwidth", kHilControls) ==
           kPackets;
  }));
  const auto sent = fixture.status("sim").tx;
  const double elapsed_s = base::to_seconds(base::steady_now() - begin);
  EXPECT_LT(static_cast<double>(sent.bytes), 20'000 * elapsed_s + 200);
  EXPECT_GT(sent.packets, 0U);
}

TEST(CasdDrops, AreCountedByLinkMessageAndCause) {
  CasdFixture fixture(kHilTopology);
  mavlink::common::CommandLong command{.target_system = 77};
  for (int i = 0; i < 3; ++i)
    fixture.sim.send(fixture.from_sim(mavlink::common::HilStateQuaternion{}));
  for (int i = 0; i < 2; ++i) fixture.sim.send(fixture.from_sim(command));
  auto broken = fixture.from_sim(hil_sensor(1));
  std::vector<std::uint8_t> bytes(broken.begin(), broken.end());
  bytes[20] ^= 1U;
  fixture.sim.send(bytes);
  ASSERT_TRUE(wait_until([&] {
    return fixture.status("sim").rx.packets == 5 && fixture.status("sim").rx.crc_errors == 1;
  }));
  EXPECT_EQ(counted(fixture, "sim", "drop.no_rule", mavlink::common::HilStateQuaternion::kId), 3U);
  // casd's own station hears commands whatever the routes say; this one has no target.
  EXPECT_EQ(counted(fixture, "sim", "drop.no_target", mavlink::common::CommandLong::kId), 2U);

  fixture.fcu.hang_up();
  ASSERT_TRUE(wait_until([&] { return fixture.status("fcu").state == casd::LinkState::kDown; }));
  fixture.sim.send(fixture.from_sim(hil_sensor(2)));
  ASSERT_TRUE(wait_until([&] { return counted(fixture, "fcu", "drop.closed", kHilSensor) == 1; }));
}

}  // namespace
}  // namespace cas::test
