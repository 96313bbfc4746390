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
  mavlink::common::HilSensor sensor;
  sensor.time_usec = n;
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
    mavlink::common::HilSensor sensor;
    sensor.time_usec = i;
    sensor.fields_updated = static_cast<mavlink::common::HilSensorUpdatedFlags>(random() & 0x1FFFU);
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

TEST(DuplicateFilter, ForgetsAfterTheWindow) {
  DuplicateFilter filter;
  filter.is_duplicate(kOne, view(nth(1)), at({}), kWindow);
  EXPECT_FALSE(filter.is_duplicate(kOther, view(nth(1)), at(kWindow + milliseconds(1)), kWindow));
}

}  // namespace
}  // namespace cas::casd::test
