// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/line_timing.hpp"

#include <gtest/gtest.h>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using std::chrono::milliseconds;

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
