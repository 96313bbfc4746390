// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/line_timing.hpp"

#include <gtest/gtest.h>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using std::chrono::milliseconds;

TEST(LinePacer, WithoutARateIsAlwaysReady) {
  LinePacer line;
  line.sent(1'000'000, at({}));
  EXPECT_TRUE(line.ready(at({})));
  EXPECT_EQ(line.arrival(100, at({})), at({}));
}

TEST(LinePacer, CarriesNinetyEightPercentOfTheLine) {
  LinePacer line(LinePacer::rate_of(115200));
  std::size_t sent = 0;
  for (base::Duration now{}; now < std::chrono::seconds(10); now += microseconds(50)) {
    while (line.ready(at(now))) {
      line.sent(77, at(now));
      sent += 77;
    }
  }
  EXPECT_NEAR(static_cast<double>(sent), 0.98 * 115200, 2 * 77);
}

TEST(LinePacer, GivesTheLineBytesHalfAMillisecondAhead) {
  LinePacer line(LinePacer::rate_of(921600));
  line.sent(903, at({}));  // 10 ms
  EXPECT_FALSE(line.ready(at(microseconds(9400))));
  EXPECT_TRUE(line.ready(at(microseconds(9600))));
  EXPECT_NEAR(base::to_seconds(line.ready_at() - at({})), 0.0095, 1e-5);
}

TEST(LinePacer, KeepsSensorPacketsApart) {
  LinePacer line;  // USB: no rate of its own
  line.set_sensor_gap(std::chrono::milliseconds(3));
  line.sent(77, at({}));
  EXPECT_TRUE(line.ready(at({}))) << "other packets hold nothing";
  line.sent_sensor(at({}));
  EXPECT_FALSE(line.ready(at(microseconds(2999))));
  EXPECT_EQ(line.ready_at(), at(std::chrono::milliseconds(3)));
  EXPECT_TRUE(line.ready(at(std::chrono::milliseconds(3))));
  EXPECT_EQ(line.arrival(100, at({})), at(std::chrono::milliseconds(3)));
}

TEST(LinePacer, IdleTimeIsNotSavedUp) {
  LinePacer line(LinePacer::rate_of(115200));
  line.sent(77, at(std::chrono::seconds(100)));
  EXPECT_FALSE(line.ready(at(std::chrono::seconds(100))));
}

TEST(LinePacer, KnowsWhenAPacketWillHaveArrived) {
  LinePacer line(1000.0);
  EXPECT_EQ(line.arrival(10, at({})), at(milliseconds(10)));
  line.sent(10, at({}));
  EXPECT_EQ(line.arrival(10, at({})), at(milliseconds(20)));
}

// 460 800 baud: a HIL_SENSOR of 72 bytes and the FIFO's 16.
constexpr base::Duration kPacketTime = microseconds(1562);
constexpr base::Duration kFifoTime = microseconds(347);

TEST(LineDrain, WithoutATickEndsWithTheLastBit) {
  const LineDrain drain(base::Duration{});
  EXPECT_EQ(drain.done(at({}), at(kPacketTime), kFifoTime), at(kPacketTime));
}

TEST(LineDrain, SleepsForTheBegunTickAndAWholeOne) {
  const LineDrain drain(milliseconds(1));
  // The buffer is empty 1.2 ms after the write; the next look is at the second tick after that.
  EXPECT_EQ(drain.done(at({}), at(kPacketTime), kFifoTime), at(milliseconds(3)));
  // Begun half a tick later, it is empty at 1.7 ms: in the same tick.
  const base::Duration later = microseconds(500);
  EXPECT_EQ(drain.done(at(later), at(later + kPacketTime), kFifoTime), at(milliseconds(3)));
}

TEST(LineDrain, OfDebiansKernelTakesEightMilliseconds) {
  const LineDrain drain(milliseconds(4));
  EXPECT_EQ(drain.done(at({}), at(kPacketTime), kFifoTime), at(milliseconds(8)));
}

TEST(LineDrain, LooksAgainUntilTheLineIsThrough) {
  const LineDrain drain(milliseconds(1));
  const base::Duration fifo = milliseconds(5);  // 32 kbaud
  EXPECT_EQ(drain.done(at({}), at(milliseconds(5)), fifo), at(milliseconds(6)));
}

TEST(LineDrain, DoesNotWaitForWhatIsSent) {
  const LineDrain drain(milliseconds(1));
  EXPECT_EQ(drain.done(at(microseconds(700)), at({}), kFifoTime), at(microseconds(700)));
}

}  // namespace
}  // namespace cas::casd::test
