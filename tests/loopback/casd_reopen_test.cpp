// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

bool is_up(CasdFixture& fixture, const std::string& link) {
  return fixture.status(link).state == casd::LinkState::kUp;
}

std::uint64_t lost_while_away(CasdFixture& fixture) {
  return fixture.status("fcu").tx.dropped[static_cast<std::size_t>(casd::DropCause::kClosed)];
}

TEST(CasdReopen, SerialLineComesBackWithoutAnythingStale) {
  CasdFixture fixture(kHilTopology);
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));

  fixture.fcu.hang_up();
  ASSERT_TRUE(wait_until([&] { return !is_up(fixture, "fcu"); }));
  for (std::uint64_t i = 2; i <= 50; ++i) fixture.sim.send(fixture.from_sim(hil_sensor(i)));
  ASSERT_TRUE(wait_until([&] { return lost_while_away(fixture) == 49; }));

  fixture.fcu.come_back();
  const base::RunTime back = base::steady_now();
  ASSERT_TRUE(wait_until([&] { return is_up(fixture, "fcu"); }));
  RecordProperty("reopen_us", static_cast<int>((base::steady_now() - back).count() / 1000));
  fixture.sim.send(fixture.from_sim(hil_sensor(51)));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(fixture.collect_until([&] {
    return fixture.at_fcu.count(kHilSensor) == 2 && fixture.at_sim.count(kHilControls) == 1;
  }));
  EXPECT_EQ(numbers(fixture.at_fcu, kHilSensor).back(), 51U);
  EXPECT_EQ(fixture.status("fcu").reconnects, 1U);
  EXPECT_EQ(fixture.status("fcu").tx.dropped[static_cast<std::size_t>(casd::DropCause::kClosed)],
            49U);
}

TEST(CasdReopen, SerialLineSurvivesBeingPulledUnderLoadManyTimes) {
  CasdFixture fixture(kHilTopology);
  std::uint64_t number = 0;
  for (int round = 1; round <= 5; ++round) {
    fixture.fcu.come_back();
    const std::size_t before = fixture.at_fcu.count(kHilSensor);
    ASSERT_TRUE(fixture.collect_until([&] {
      fixture.sim.send(fixture.from_sim(hil_sensor(++number)));
      return fixture.at_fcu.count(kHilSensor) > before + 5;
    })) << round;
  }
  // Cut packets can only stand where a line was cut; each new line begins with a whole one.
  const auto seen = numbers(fixture.at_fcu, kHilSensor);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
}

TEST(CasdReopen, FindsItsDeviceByBeingToldFiftyTimes) {
  // A retry would come a minute late.
  const casd::RetryTimes never{std::chrono::minutes(1), std::chrono::minutes(1)};
  constexpr int kReplugs = 50;
  // A line that lasted no longer is left alone for a moment.
  constexpr auto kLasts = std::chrono::milliseconds(60);
  CasdFixture fixture(kHilTopology, never);
  ASSERT_TRUE(is_up(fixture, "fcu"));
  std::vector<base::Duration> times;
  std::uint64_t number = 0;
  std::uint64_t stale = 0;
  base::RunTime up = base::steady_now();
  for (int round = 1; round <= kReplugs; ++round) {
    ASSERT_TRUE(wait_until([&] { return base::steady_now() - up > kLasts; }));
    fixture.fcu.hang_up();
    ASSERT_TRUE(wait_until([&] { return !is_up(fixture, "fcu"); }));
    const std::uint64_t lost = lost_while_away(fixture);
    fixture.sim.send(fixture.from_sim(hil_sensor(++number)));
    ASSERT_TRUE(wait_until([&] { return lost_while_away(fixture) > lost; }));
    const std::uint64_t last_before = number;
    fixture.fcu.come_back();  // made under another name and renamed, as udev does it
    const base::RunTime back = base::steady_now();
    while (!is_up(fixture, "fcu") || fixture.status("fcu").reconnects < std::uint64_t(round)) {
      ASSERT_LT(base::steady_now() - back, std::chrono::seconds(20)) << "round " << round;
      ::poll(nullptr, 0, 1);
    }
    up = base::steady_now();
    times.push_back(up - back);
    fixture.sim.send(fixture.from_sim(hil_sensor(++number)));
    ASSERT_TRUE(fixture.collect_until([&] {
      const auto seen = numbers(fixture.at_fcu, kHilSensor);
      return !seen.empty() && seen.back() == number;
    })) << "round "
        << round;
    for (const std::uint64_t seen : numbers(fixture.at_fcu, kHilSensor)) {
      stale += seen <= last_before ? 1 : 0;
    }
    fixture.at_fcu.packets().clear();
  }
  EXPECT_EQ(stale, 0U);
  std::sort(times.begin(), times.end());
  const auto us = [](base::Duration time) { return static_cast<int>(time.count() / 1000); };
  RecordProperty("replug_p50_us", us(times[times.size() / 2]));
  RecordProperty("replug_max_us", us(times.back()));
}

TEST(CasdReopen, StartsWithoutTheDevice) {
  CasdFixture fixture;
  fixture.fcu.hang_up();
  fixture.start(kHilTopology);
  EXPECT_FALSE(is_up(fixture, "fcu"));
  fixture.fcu.come_back();
  ASSERT_TRUE(wait_until([&] { return is_up(fixture, "fcu"); }));
}

TEST(CasdReopen, FolderOfTheDeviceMayComeLate) {
  CasdFixture fixture(R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$DIR/by-id/fcu", baud: 57600}
)");
  EXPECT_FALSE(is_up(fixture, "fcu"));
  std::filesystem::create_directory(fixture.folder / "by-id");
  PtyPair line(fixture.folder / "by-id/fcu");
  ASSERT_TRUE(wait_until([&] { return is_up(fixture, "fcu"); }));
}

TEST(CasdReopen, PortInUseIsTakenOnceItIsFree) {
  CasdFixture fixture;
  auto squatter = std::make_unique<UdpPeer>();
  fixture.start("schema: 1\nlinks:\n  - {name: sim, type: udp, local: \"" + squatter->endpoint() +
                "\"}\n");
  EXPECT_FALSE(is_up(fixture, "sim"));
  squatter.reset();
  ASSERT_TRUE(wait_until([&] { return is_up(fixture, "sim"); }));
}

TEST(CasdReopen, SecondOwnerOfADeviceIsRefused) {
  CasdFixture fixture(kHilTopology);
  CasdFixture other;
  other.start("schema: 1\nlinks:\n  - {name: fcu, type: serial, device: " + fixture.fcu.slave() +
              ", unlocked_pty: true}\n");
  EXPECT_FALSE(is_up(other, "fcu"));
  EXPECT_NE(other.status("fcu").endpoint.find("in use"), std::string::npos)
      << other.status("fcu").endpoint;
  EXPECT_TRUE(is_up(fixture, "fcu"));
}

}  // namespace
}  // namespace cas::test
