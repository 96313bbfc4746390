// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <thread>

#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

std::vector<std::uint64_t> one_to(std::uint64_t last) {
  std::vector<std::uint64_t> all(last);
  std::iota(all.begin(), all.end(), std::uint64_t{1});
  return all;
}

TEST(CasdLine, IsPacedToItsRateAndDropsOnlyWhatIsTooOld) {
  CasdFixture fixture(R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: fcu, type: serial, device: "$FCU", baud: 115200}
)");
  // 100 packets at once: 7.7 kB are 0.67 s of this line, far beyond the age limit of 25 ms.
  constexpr std::uint64_t kPackets = 100;
  for (std::uint64_t i = 1; i <= kPackets; ++i) fixture.sim.send(fixture.from_sim(hil_sensor(i)));
  fixture.sim.send(fixture.from_sim(mavlink::common::CommandLong{}));
  const auto aged = [&] {
    return fixture.status("fcu").tx.dropped[static_cast<std::size_t>(casd::DropCause::kAge)];
  };
  EXPECT_TRUE(fixture.collect_until([&] {
    return fixture.at_fcu.count(mavlink::common::CommandLong::kId) == 1 &&
           fixture.at_fcu.count(kHilSensor) + aged() == kPackets;
  })) << aged();
  EXPECT_GT(aged(), 0U);
  EXPECT_EQ(fixture.at_fcu.garbage(), 0U);
}

TEST(CasdLine, FinishesEveryPacketItBegan) {
  CasdFixture fixture(R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
)");
  // The controller does not read: the line fills up in the middle of a packet.
  constexpr std::uint64_t kPackets = 3000;
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    fixture.sim.send(fixture.from_sim(hil_sensor(i)));
    if (i % 50 == 0) {
      ASSERT_TRUE(wait_until([&] { return fixture.status("sim").rx.packets == i; }));
    }
  }
  EXPECT_GT(fixture.status("fcu").tx.queued, 0U);
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == kPackets; }));
  EXPECT_EQ(numbers(fixture.at_fcu, kHilSensor), one_to(kPackets));
  EXPECT_EQ(fixture.at_fcu.garbage(), 0U);
}

/// Reads a line like a UART whose clock runs at `share` of the nominal rate: never a byte early.
class ByteClock {
 public:
  ByteClock(PtyPair& line, double bytes_s) : line_(line), bytes_s_(bytes_s) {}

  /// Reads the bytes that the clock has let through. @return bytes that wait beyond that
  std::size_t turn(PacketStream& into) {
    const base::RunTime now = base::steady_now();
    int waiting = 0;
    ::ioctl(line_.master(), FIONREAD, &waiting);
    if (waiting == 0) credit_ = 0;  // an idle line saves up nothing
    if (last_ != base::RunTime{}) credit_ += bytes_s_ * base::to_seconds(now - last_);
    last_ = now;
    const auto most = static_cast<std::size_t>(credit_);
    const std::size_t taken = most == 0 ? 0 : line_.read(into, most);
    credit_ -= static_cast<double>(taken);
    return static_cast<std::size_t>(waiting) -
           std::min<std::size_t>(taken, static_cast<std::size_t>(waiting));
  }

 private:
  PtyPair& line_;
  double bytes_s_;
  double credit_ = 0;
  base::RunTime last_{};
};

TEST(CasdLine, DoesNotFillUpAgainstAClockThatRunsSlow) {
  constexpr double kBytes_s = 92'160;  // 921600 baud
  CasdFixture fixture;
  std::string yaml = kHilTopology;
  const std::string patient = "queue: {hil_max_age_ms: 60000}";
  // Excess packets expire by age. A reader delayed for less than that by a busy machine is no
  // standstill, after which casd would probe the line with a stray byte.
  yaml.replace(yaml.rfind(patient), patient.size(), "queue: {hil_max_age_ms: 100}, pace: true");
  fixture.start(yaml);
  ByteClock uart(fixture.fcu, kBytes_s * 0.985);
  // A tenth more than the line carries. Without the two percent in hand 1.5 % of a second's bytes
  // would pile up each second: 1400, and 1400 more.
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> sent{0};
  std::thread simulator([&] {
    const base::RunTime begin = base::steady_now();
    for (std::uint64_t i = 1; !stop; ++i) {
      fixture.sim.send(fixture.from_sim(hil_sensor(i)));
      sent = i;
      while (!stop && base::to_seconds(base::steady_now() - begin) * kBytes_s * 1.1 / 70 <
                          static_cast<double>(i)) {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
    }
  });
  const base::RunTime begin = base::steady_now();
  constexpr std::size_t kFew = 400;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  EXPECT_TRUE(wait_until([&] {
    const std::size_t waiting = uart.turn(fixture.at_fcu);
    const base::Duration elapsed = base::steady_now() - begin;
    // The least of the last moments: a busy machine makes the rest.
    if (elapsed > std::chrono::milliseconds(1500)) least = std::min(least, waiting);
    return elapsed > std::chrono::milliseconds(1800) &&
           (least < kFew || elapsed > std::chrono::seconds(10));
  }));
  stop = true;
  simulator.join();
  EXPECT_LT(least, kFew);
  // Of some 2000 packets: one that a busy machine leaves half written for its whole age is spoilt.
  constexpr std::size_t kPacket = 77;
  EXPECT_LE(fixture.at_fcu.garbage(), 5 * kPacket);
  EXPECT_LT(fixture.at_fcu.count(kHilSensor), sent.load()) << "more came than the line carries";
}

}  // namespace
}  // namespace cas::test
