// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/ground_station.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(GroundStation, FloodsAtItsRateHoweverShortTheTicks) {
  std::size_t sent = 0;
  GroundStation station({1}, kParameterListPeriod,
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
  GroundStation station({1}, kParameterListPeriod,
                        [&sent](std::span<const std::uint8_t>) { ++sent; });
  base::RunTime now{seconds(10)};
  station.flood(100);
  station.tick(now);
  sent = 0;
  station.tick(now + seconds(5));
  constexpr std::size_t kHeartbeats = 1;
  EXPECT_EQ(sent, 10 + kHeartbeats);
}

TEST(GroundStation, AttendsEachVehicleThatItHasHeard) {
  std::map<std::uint8_t, int> sticks;
  mav::PacketParser parser(mavlink::common::table());
  GroundStation station({1, 2, 3}, kParameterListPeriod, [&](std::span<const std::uint8_t> bytes) {
    parser.feed(bytes, [&](const mav::PacketView& packet) {
      const auto message = mav::decode<mavlink::common::ManualControl>(packet);
      if (message) ++sticks[message->target];
    });
  });
  for (const std::uint8_t system : {std::uint8_t{1}, std::uint8_t{3}}) {
    mav::Encoder vehicle({system, 1});
    station.on_bytes(vehicle(mavlink::common::Heartbeat{}));
  }
  base::RunTime now{seconds(10)};
  for (int i = 0; i < 10; ++i) station.tick(now += GroundStation::kTickPeriod);
  EXPECT_EQ(sticks, (std::map<std::uint8_t, int>{{1, 5}, {3, 5}}));
}

}  // namespace
}  // namespace cas::hils
