// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ground_station.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace cas::hils {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(GroundStation, FloodsAtItsRateHoweverShortTheTicks) {
  std::size_t sent = 0;
  GroundStation station(1, kParameterListPeriod,
                        [&sent](std::span<const std::uint8_t>) { ++sent; });
  base::RunTime now{seconds(10)};
  station.tick(now);
  sent = 0;
  station.flood(100);
  for (int i = 0; i < 1000; ++i) station.tick(now += milliseconds(1));
  constexpr std::size_t kHeartbeats = 1;
  EXPECT_EQ(sent, 100 + kHeartbeats);
}

TEST(GroundStation, SendsNoBurstAfterAStall) {
  std::size_t sent = 0;
  GroundStation station(1, kParameterListPeriod,
                        [&sent](std::span<const std::uint8_t>) { ++sent; });
  base::RunTime now{seconds(10)};
  station.flood(100);
  station.tick(now);
  sent = 0;
  station.tick(now + seconds(5));
  constexpr std::size_t kHeartbeats = 1;
  EXPECT_EQ(sent, 10 + kHeartbeats);
}

}  // namespace
}  // namespace cas::hils
