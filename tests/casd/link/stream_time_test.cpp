// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/stream_time.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/casd/packets.hpp"

namespace cas::casd {
namespace {

using base::RunTime;
using mavlink::common::HilGps;
using mavlink::common::HilSensor;
using test::milliseconds;

constexpr mav::Source kSimulator{1, 200};

/// Events in their order: "turn 50" and "before".
class StreamTimeTest : public testing::Test {
 protected:
  StreamTimeTest() {
    time_.enable([this](RunTime now) {
      events_.push_back("turn " + std::to_string(now.time_since_epoch() / milliseconds(1)));
    });
  }
  void sensor(std::uint64_t time_usec) {
    const mav::PacketBuffer buffer = test::packet(HilSensor{.time_usec = time_usec}, kSimulator);
    time_.on_packet(test::view(buffer), [this] { events_.emplace_back("before"); });
  }

  StreamTime time_;
  std::vector<std::string> events_;
};

TEST_F(StreamTimeTest, ShowsTheNewestSensorsStamp) {
  EXPECT_EQ(time_.now(), RunTime{});
  sensor(12'345);
  EXPECT_EQ(time_.now(), RunTime(std::chrono::microseconds(12'345)));
}

TEST_F(StreamTimeTest, GivesATurnEachFiftyMillisecondsOnAGrid) {
  for (std::uint64_t ms = 2; ms <= 160; ms += 2) sensor(1000 * ms);
  EXPECT_EQ(events_, (std::vector<std::string>{"before", "turn 2", "before", "turn 50", "before",
                                               "turn 100", "before", "turn 150"}));
}

TEST_F(StreamTimeTest, OtherMessagesMoveNothing) {
  const mav::PacketBuffer buffer = test::packet(HilGps{.time_usec = 77'000}, kSimulator);
  time_.on_packet(test::view(buffer), [this] { events_.emplace_back("before"); });
  EXPECT_EQ(time_.now(), RunTime{});
  EXPECT_TRUE(events_.empty());
}

TEST_F(StreamTimeTest, GoesOnWhenTheSimulationStartsAnew) {
  sensor(3'000'000);
  sensor(2'000);
  EXPECT_EQ(time_.now(), RunTime(milliseconds(3'002)));
}

TEST(StreamTime, IsOffUnlessEnabled) {
  StreamTime time;
  const mav::PacketBuffer buffer = test::packet(HilSensor{.time_usec = 5'000}, kSimulator);
  time.on_packet(test::view(buffer), [] { FAIL(); });
  EXPECT_EQ(time.now(), RunTime{});
}

}  // namespace
}  // namespace cas::casd
