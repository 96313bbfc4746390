// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/loopback/casd_bench.hpp"

namespace cas::test {
namespace {

bool is_up(CasdBench& bench, const std::string& link) {
  return bench.status(link).state == casd::LinkState::kUp;
}

TEST(CasdReopen, SerialLineComesBackWithoutAnythingStale) {
  CasdBench bench;
  bench.start(kHilTopology);
  bench.sim.send(bench.from_sim(hil_sensor(1)));
  ASSERT_TRUE(bench.collect_until([&] { return bench.at_fcu.count(kHilSensor) == 1; }));

  bench.fcu.hang_up();
  ASSERT_TRUE(wait_until([&] { return !is_up(bench, "fcu"); }));
  for (std::uint64_t i = 2; i <= 50; ++i) bench.sim.send(bench.from_sim(hil_sensor(i)));
  ASSERT_TRUE(wait_until([&] { return bench.status("sim").rx.packets == 50; }));

  bench.fcu.come_back();
  const base::RunTime back = base::steady_now();
  ASSERT_TRUE(wait_until([&] { return is_up(bench, "fcu"); }));
  RecordProperty("reopen_us", static_cast<int>((base::steady_now() - back).count() / 1000));
  bench.sim.send(bench.from_sim(hil_sensor(51)));
  bench.fcu.write(bench.from_fcu(hil_controls(1)));
  ASSERT_TRUE(bench.collect_until([&] {
    return bench.at_fcu.count(kHilSensor) == 2 && bench.at_sim.count(kHilControls) == 1;
  }));
  EXPECT_EQ(numbers(bench.at_fcu, kHilSensor).back(), 51U);
  EXPECT_EQ(bench.status("fcu").reconnects, 1U);
  EXPECT_EQ(bench.status("fcu").tx.dropped[static_cast<std::size_t>(casd::DropCause::kClosed)],
            49U);
}

TEST(CasdReopen, SerialLineSurvivesBeingPulledUnderLoadManyTimes) {
  CasdBench bench;
  bench.start(kHilTopology);
  std::uint64_t number = 0;
  for (int round = 1; round <= 5; ++round) {
    bench.fcu.come_back();
    const std::size_t before = bench.at_fcu.count(kHilSensor);
    ASSERT_TRUE(bench.collect_until([&] {
      bench.sim.send(bench.from_sim(hil_sensor(++number)));
      return bench.at_fcu.count(kHilSensor) > before + 5;
    })) << round;
  }
  // Cut packets can only stand where a line was cut; each new line begins with a whole one.
  const auto seen = numbers(bench.at_fcu, kHilSensor);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
}

TEST(CasdReopen, StartsWithoutTheDevice) {
  CasdBench bench;
  bench.fcu.hang_up();
  bench.start(kHilTopology);
  EXPECT_FALSE(is_up(bench, "fcu"));
  bench.fcu.come_back();
  ASSERT_TRUE(wait_until([&] { return is_up(bench, "fcu"); }));
}

TEST(CasdReopen, FolderOfTheDeviceMayComeLate) {
  CasdBench bench;
  bench.start(R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$DIR/by-id/fcu", baud: 57600}
)");
  EXPECT_FALSE(is_up(bench, "fcu"));
  std::filesystem::create_directory(bench.folder / "by-id");
  PtyPair line(bench.folder / "by-id/fcu");
  ASSERT_TRUE(wait_until([&] { return is_up(bench, "fcu"); }));
}

TEST(CasdReopen, PortInUseIsTakenOnceItIsFree) {
  CasdBench bench;
  auto squatter = std::make_unique<UdpPeer>();
  bench.start("schema: 1\nlinks:\n  - {name: sim, type: udp, local: \"" + squatter->endpoint() +
              "\"}\n");
  EXPECT_FALSE(is_up(bench, "sim"));
  squatter.reset();
  ASSERT_TRUE(wait_until([&] { return is_up(bench, "sim"); }));
}

TEST(CasdReopen, SecondOwnerOfADeviceIsRefused) {
  CasdBench bench;
  bench.start(kHilTopology);
  CasdBench other;
  other.start("schema: 1\nlinks:\n  - {name: fcu, type: serial, device: " + bench.fcu.slave() +
              "}\n");
  EXPECT_FALSE(is_up(other, "fcu"));
  EXPECT_TRUE(is_up(bench, "fcu"));
}

}  // namespace
}  // namespace cas::test
