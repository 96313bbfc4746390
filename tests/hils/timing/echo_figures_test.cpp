// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/echo_figures.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "base/random.hpp"
#include "hils/timing/byte_rate.hpp"

namespace cas::hils {
namespace {

using namespace std::chrono_literals;

TEST(EchoFigures, CountAndOrderRoundTrips) {
  std::vector<base::Duration> times;
  for (int i = 1; i <= 101; ++i) times.push_back(std::chrono::milliseconds(i));
  const EchoFigures figures = echo_figures(103, times);
  EXPECT_EQ(figures.lost(), 2U);
  EXPECT_DOUBLE_EQ(figures.least_ms, 1);
  EXPECT_DOUBLE_EQ(figures.median_ms, 51);
  EXPECT_DOUBLE_EQ(figures.p99_ms, 100);
  EXPECT_DOUBLE_EQ(figures.longest_ms, 101);
  EXPECT_NEAR(figures.jitter_ms, 1, 1e-9) << "each takes a millisecond more than the one before";
}

TEST(EchoFigures, OfNothingAreZero) {
  EXPECT_EQ(echo_figures(0, {}).lost_share(), 0);
  EXPECT_EQ(echo_figures(5, {}).lost_share(), 1);
  EXPECT_EQ(echo_figures(5, {}).median_ms, 0);
}

/// Answers to 150 questions, 5 to 15 ms apart at random, that arrive in frames of the host's clock.
/// @param drift  by which the frame clock is off, a share
std::vector<base::RunTime> arrivals(base::Duration frame, base::Duration jitter, double drift) {
  base::NormalRandom random(7);
  std::vector<base::RunTime> all;
  base::RunTime now{};
  for (int i = 0; i < 150; ++i) {
    now += 5ms + base::from_seconds(random.uniform() * 0.01);
    base::Duration at = now.time_since_epoch();
    if (frame > 0ns) {
      const double length = base::to_seconds(frame) * (1 + drift);
      at = base::from_seconds(length * std::ceil(base::to_seconds(at) / length));
    }
    all.push_back(
        base::RunTime(at + base::from_seconds(random.uniform() * base::to_seconds(jitter))));
  }
  return all;
}

TEST(ArrivalFrame, IsSeenUnlessItIsBlurred) {
  struct FrameCase {
    const char* name;
    base::Duration frame;
    base::Duration jitter;  // of the program that reads
    double drift;
    std::optional<base::Duration> seen;
  };
  const FrameCase rows[] = {{"Uart", 0ns, 50us, 0, std::nullopt},
                            {"FullSpeedUsb", 1ms, 100us, 0, 1ms},
                            {"FullSpeedUsbWithAClockThatIs500PpmOff", 1ms, 100us, 5e-4, 1ms},
                            {"HighSpeedUsb", 125us, 20us, 0, 125us},
                            {"HighSpeedUsbBlurredByTheReader", 125us, 125us, 0, std::nullopt},
                            {"LatencyTimerOfAnAdapter", 16ms, 500us, 0, 16ms}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    EXPECT_EQ(arrival_frame(arrivals(test.frame, test.jitter, test.drift)), test.seen);
  }
}

TEST(ArrivalFrameOfFew, IsNotTold) {
  const auto all = arrivals(1ms, 0ns, 0);
  EXPECT_EQ(arrival_frame(std::span(all).first(40)), std::nullopt);
}

TEST(ByteRate, IsThatOfTheMedianPiece) {
  ByteRate rate;
  base::RunTime now{};
  std::size_t total = 0;
  for (int i = 0; i <= 50; ++i) {
    rate.add(total, now);
    total += 100;
    now += i == 5 || i == 15 ? 200ms : 10ms;  // two pauses, in two of five pieces
  }
  EXPECT_NEAR(rate.bytes_s(), 10'000, 1);
}

TEST(ByteRateWithPauses, IsNeverAboveTheLines) {
  // 5760 bytes/s in parts of 256, for 1.5 s. This machine sleeps at the beginning of each cycle,
  // then reads the waiting parts, one each 20 us.
  struct Pauses {
    const char* name;
    base::Duration cycle;
    base::Duration asleep;
  };
  const Pauses rows[] = {{"None", 1s, 0ns},
                         {"Short", 110ms, 60ms},
                         {"Long", 400ms, 350ms},
                         {"Longer", 700ms, 600ms},
                         {"NearlyAll", 1600ms, 1450ms}};
  for (const auto& [name, cycle, asleep] : rows) {
    SCOPED_TRACE(name);
    constexpr double kBytes_s = 5760;
    constexpr std::size_t kPart = 256;
    ByteRate rate;
    base::RunTime now{};
    rate.add(0, now);
    for (std::size_t total = kPart; static_cast<double>(total) < 1.5 * kBytes_s; total += kPart) {
      const base::Duration through = base::from_seconds(static_cast<double>(total) / kBytes_s);
      const base::Duration in_cycle = through % cycle;
      const base::Duration awake = in_cycle < asleep ? through - in_cycle + asleep : through;
      now = std::max(now + 20us, base::RunTime(awake));
      rate.add(total, now);
    }
    // A pause begins and ends up to a part from the byte clock's.
    EXPECT_LT(rate.bytes_s(), 1.2 * kBytes_s);
    EXPECT_GT(rate.bytes_s(), 0.8 * kBytes_s);
  }
}

TEST(ByteRate, OfTooFewMarksIsNotTold) {
  ByteRate rate;
  for (int i = 0; i < 5; ++i) rate.add(100, base::RunTime(std::chrono::seconds(i)));
  EXPECT_EQ(rate.bytes_s(), 0);
}

}  // namespace
}  // namespace cas::hils
