// SPDX-License-Identifier: BSD-3-Clause
// Groups, rates, caps, and the account of everything that did not go on.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/loopback/casd_bench.hpp"

namespace cas::test {
namespace {

/// How many packets of a message a link counted under "rx", "tx" or "drop.CAUSE".
std::uint64_t counted(CasdBench& bench, const std::string& link, const std::string& direction,
                      std::uint32_t message) {
  std::uint64_t sum = 0;
  for (const auto& entry : bench.links().figures().messages(base::steady_now(), link)) {
    if (entry.direction == direction && entry.id == message) sum += entry.count;
  }
  return sum;
}

TEST(CasdGroup, PassesEachPacketOnceWhicheverPathIsFirst) {
  CasdBench bench;
  UdpPeer path_a;
  UdpPeer path_b;
  bench.start(R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
  - {name: a, type: udp, local: "127.0.0.1:0", group: wing}
  - {name: b, type: udp, local: "127.0.0.1:0", group: wing}
)");
  path_a.set_remote(bench.port("a"));
  path_b.set_remote(bench.port("b"));
  constexpr std::uint64_t kPackets = 2000;
  constexpr std::uint64_t kLag = 200;  // path b brings everything this much later
  std::vector<std::vector<std::uint8_t>> late;
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    const auto packet = bench.from_sim(hil_sensor(i));
    path_a.send(packet);
    late.emplace_back(packet.begin(), packet.end());
    if (i % 50 != 0) continue;
    ASSERT_TRUE(bench.collect_until([&] { return bench.status("a").rx.packets == i; }));
    while (late.size() > kLag) {
      for (std::size_t k = 0; k < 50; ++k) path_b.send(late[k]);
      late.erase(late.begin(), late.begin() + 50);
    }
  }
  for (const auto& packet : late) path_b.send(packet);
  ASSERT_TRUE(bench.collect_until([&] { return bench.status("b").rx.packets == kPackets; }));
  ASSERT_TRUE(bench.collect_until([&] { return bench.at_fcu.count(kHilSensor) >= kPackets; }));
  EXPECT_EQ(bench.at_fcu.count(kHilSensor), kPackets);
  EXPECT_EQ(counted(bench, "b", "drop.duplicate", kHilSensor), kPackets);
  EXPECT_EQ(counted(bench, "a", "drop.duplicate", kHilSensor), 0U);
}

TEST(CasdRates, ThinOutAMessageAndCountWhatWasLeftOut) {
  CasdBench bench;
  bench.start(R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
routes:
  - {from: sim, to: fcu, rates: {HIL_SENSOR: {every: 5}, HEARTBEAT: 0.001}}
)");
  for (std::uint64_t i = 1; i <= 100; ++i) {
    bench.sim.send(bench.from_sim(hil_sensor(i)));
    bench.sim.send(bench.from_sim(mavlink::common::Heartbeat{}));
  }
  ASSERT_TRUE(bench.collect_until([&] {
    return bench.at_fcu.count(kHilSensor) == 20 && bench.status("sim").rx.packets == 200;
  }));
  EXPECT_EQ(bench.at_fcu.count(kHeartbeat), 1U);
  EXPECT_EQ(counted(bench, "sim", "drop.rate_limited", kHilSensor), 80U);
  EXPECT_EQ(counted(bench, "sim", "drop.rate_limited", kHeartbeat), 99U);
}

TEST(CasdCap, HoldsALinkToItsBytesASecondAndCountsTheRestAsBandwidth) {
  CasdBench bench;
  bench.start(R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$FCU"}
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM", max_bytes_s: 20000}
)");
  // 5000 packets of 54 bytes: 13 s at this rate, against an age limit of 25 ms.
  constexpr std::uint64_t kPackets = 5000;
  const base::RunTime begin = base::steady_now();
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    bench.fcu.write(bench.from_fcu(hil_controls(i)));
    if (i % 50 == 0) bench.collect();
  }
  ASSERT_TRUE(bench.collect_until([&] {
    return bench.status("fcu").rx.packets == kPackets && bench.status("sim").tx.queued == 0;
  }));
  const double elapsed_s = base::to_seconds(base::steady_now() - begin);
  const auto sent = bench.status("sim").tx;
  EXPECT_LT(static_cast<double>(sent.bytes), 20'000 * elapsed_s + 200);
  EXPECT_EQ(sent.packets + counted(bench, "sim", "drop.bandwidth", kHilControls), kPackets);
  EXPECT_GT(sent.packets, 0U);
}

TEST(CasdDrops, AreCountedByLinkMessageAndCause) {
  CasdBench bench;
  bench.start(kHilTopology);
  mavlink::common::CommandLong command;
  command.target_system = 77;
  for (int i = 0; i < 3; ++i) bench.sim.send(bench.from_sim(mavlink::common::HilStateQuaternion{}));
  for (int i = 0; i < 2; ++i) bench.sim.send(bench.from_sim(command));
  auto broken = bench.from_sim(hil_sensor(1));
  std::vector<std::uint8_t> bytes(broken.begin(), broken.end());
  bytes[20] ^= 1U;
  bench.sim.send(bytes);
  ASSERT_TRUE(wait_until([&] {
    return bench.status("sim").rx.packets == 5 && bench.status("sim").rx.crc_errors == 1;
  }));
  EXPECT_EQ(counted(bench, "sim", "drop.no_rule", mavlink::common::HilStateQuaternion::kId), 3U);
  // casd's own station hears commands whatever the routes say; this one is for nobody.
  EXPECT_EQ(counted(bench, "sim", "drop.no_target", mavlink::common::CommandLong::kId), 2U);

  bench.fcu.hang_up();
  ASSERT_TRUE(wait_until([&] { return bench.status("fcu").state == casd::LinkState::kDown; }));
  bench.sim.send(bench.from_sim(hil_sensor(2)));
  ASSERT_TRUE(wait_until([&] { return counted(bench, "fcu", "drop.closed", kHilSensor) == 1; }));
}

}  // namespace
}  // namespace cas::test
