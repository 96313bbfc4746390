// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/duplicate_filter.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

constexpr base::Duration kWindow = milliseconds(500);
constexpr LinkId kOne = 0;
constexpr LinkId kOther = 1;

/// The n-th packet of a sender: its content counts on when the sequence number wraps.
mav::PacketBuffer nth(unsigned n, mav::Source source = {1, 1}) {
  mavlink::common::HilSensor sensor{.time_usec = n};
  return packet(sensor, source, static_cast<std::uint8_t>(n));
}

TEST(DuplicateFilter, FindsEverySecondCopyHoweverFarItLagsBehind) {
  for (const unsigned lag : {0U, 1U, 200U, 255U, 256U, 1000U, 2000U}) {
    DuplicateFilter filter;
    for (unsigned i = 0; i < 5000 + lag; ++i) {
      const base::RunTime now = at(microseconds(100 * i));
      if (i < 5000) {
        ASSERT_FALSE(filter.is_duplicate(kOne, view(nth(i)), now, kWindow)) << lag;
      }
      if (i >= lag) {
        ASSERT_TRUE(filter.is_duplicate(kOther, view(nth(i - lag)), now, kWindow))
            << lag << " " << i;
      }
    }
  }
}

TEST(DuplicateFilter, AFloodOfOneSenderCostsAnotherNoMemory) {
  DuplicateFilter filter;
  const auto mine = nth(7);
  filter.is_duplicate(kOne, view(mine), at({}), kWindow);
  for (unsigned i = 0; i < 100'000; ++i)
    filter.is_duplicate(kOne, view(nth(i, {9, 9})), at({}), kWindow);
  EXPECT_TRUE(filter.is_duplicate(kOther, view(mine), at(milliseconds(1)), kWindow));
}

TEST(DuplicateFilter, DropsNoPacketThatDiffers) {
  DuplicateFilter filter;
  std::mt19937 random(5);
  for (unsigned i = 0; i < 100'000; ++i) {
    mavlink::common::HilSensor sensor{
        .time_usec = i,
        .fields_updated = static_cast<mavlink::common::HilSensorUpdatedFlags>(random() & 0x1FFFU)};
    // Few sequence numbers and two links: nearly the same bytes all the time.
    const auto sent = packet(sensor, {1, 1}, static_cast<std::uint8_t>(random() % 3));
    const auto link = static_cast<LinkId>(random() % 2);
    ASSERT_FALSE(filter.is_duplicate(link, view(sent), at(microseconds(i)), kWindow)) << i;
  }
}

TEST(DuplicateFilter, RemembersASenderAmongManyThatCameBefore) {
  DuplicateFilter filter;
  for (unsigned system = 1; system <= 255; ++system) {
    const auto sent = nth(1, {static_cast<std::uint8_t>(system), 1});
    EXPECT_FALSE(filter.is_duplicate(kOne, view(sent), at(microseconds(system)), kWindow));
    EXPECT_TRUE(filter.is_duplicate(kOther, view(sent), at(microseconds(system)), kWindow));
  }
}

TEST(DuplicateFilter, ForgetsWhatIsTooOld) {
  DuplicateFilter filter;
  filter.is_duplicate(kOne, view(nth(1)), at({}), kWindow);
  EXPECT_FALSE(filter.is_duplicate(kOther, view(nth(1)),
                                   at(DuplicateFilter::kLatest + milliseconds(1)), kWindow));
}

/// A sender at 50 Hz whose every fifth packet is the same HEARTBEAT but for its sequence number.
mav::PacketBuffer streamed(unsigned n) {
  const auto sequence = static_cast<std::uint8_t>(n);
  if (n % 5 == 0) return packet(mavlink::common::Heartbeat{}, {1, 1}, sequence);
  return nth(n);
}
constexpr base::Duration kStep = milliseconds(20);

TEST(DuplicateFilter, FindsCopiesOfAPathThatIsSecondsLateThoughTheFirstOneLostSome) {
  for (const unsigned lag : {5U, 100U, 400U}) {
    DuplicateFilter filter;
    for (unsigned i = 0; i < 3000; ++i) {
      const base::RunTime now = at(i * kStep);
      const bool lost = i % 7 == 3;
      if (!lost) filter.is_duplicate(kOne, view(streamed(i)), now, kWindow);
      if (i < lag) continue;
      const bool had_it = (i - lag) % 7 != 3;
      if (had_it) {
        EXPECT_TRUE(filter.is_duplicate(kOther, view(streamed(i - lag)), now, kWindow)) << i;
      } else if ((i - lag) % 5 != 0) {
        EXPECT_FALSE(filter.is_duplicate(kOther, view(streamed(i - lag)), now, kWindow)) << i;
      }
    }
  }
}

TEST(DuplicateFilter, ASenderThatDoesNotCountIsHeardWhenItsFirstPathDies) {
  DuplicateFilter filter;
  const auto same = packet(mavlink::common::Heartbeat{}, {1, 1}, 0);
  constexpr int kDeath = 5;
  for (int second = 0; second < 30; ++second) {
    const base::RunTime now = at(std::chrono::seconds(second));
    const bool lives = second < kDeath;
    if (lives) {
      EXPECT_FALSE(filter.is_duplicate(kOne, view(same), now, kWindow)) << second;
    }
    const base::RunTime later = now + milliseconds(20);
    EXPECT_EQ(filter.is_duplicate(kOther, view(same), later, kWindow), lives) << second;
  }
}

// 1280 packets on, a HEARTBEAT has the same bytes again.
TEST(DuplicateFilter, WhatASenderSaysAgainIsNoCopyOfWhatADeadPathBrought) {
  DuplicateFilter filter;
  constexpr unsigned kDeath = 1000;
  for (unsigned i = 0; i < 3000; ++i) {
    const base::RunTime now = at(i * kStep / 8);
    if (i < kDeath) filter.is_duplicate(kOne, view(streamed(i)), now, kWindow);
    const bool duplicate = filter.is_duplicate(kOther, view(streamed(i)), now, kWindow);
    // The packets of the last kDisorder before its death cannot be told from copies.
    if (i < kDeath || i >= kDeath + 1280) {
      EXPECT_EQ(duplicate, i < kDeath) << i;
    } else if (i < kDeath + 900) {
      EXPECT_FALSE(duplicate) << i;
    }
  }
}

}  // namespace
}  // namespace cas::casd::test
