// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/ground_station.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

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

TEST(GroundStation, HoldsTheSticksOfAVehicleUntilTheRadioIsLost) {
  std::vector<mavlink::common::ManualControl> sticks;
  mav::PacketParser parser(mavlink::common::table());
  GroundStation station({1}, kParameterListPeriod, [&](std::span<const std::uint8_t> bytes) {
    parser.feed(bytes, [&](const mav::PacketView& packet) {
      const auto message = mav::decode<mavlink::common::ManualControl>(packet);
      if (message) sticks.push_back(*message);
    });
  });
  mav::Encoder vehicle({1, 1});
  station.on_bytes(vehicle(mavlink::common::Heartbeat{}));
  base::RunTime now{seconds(10)};
  const auto run = [&] {
    for (int i = 0; i < 10; ++i) station.tick(now += GroundStation::kTickPeriod);
    return sticks.size();
  };
  EXPECT_EQ(run(), 5U);
  EXPECT_EQ(sticks.back().z, 500) << "centred";
  station.hold(1, {.pitch = 0.7, .roll = -1, .yaw = 0.25, .climb = -0.5});
  EXPECT_EQ(run(), 10U);
  EXPECT_EQ(sticks.back().x, 700);
  EXPECT_EQ(sticks.back().y, -1000);
  EXPECT_EQ(sticks.back().r, 250);
  EXPECT_EQ(sticks.back().z, 250);
  station.lose_sticks(true);
  EXPECT_EQ(run(), 10U);
  station.lose_sticks(false);
  EXPECT_EQ(run(), 15U);
}

}  // namespace
}  // namespace cas::hils
