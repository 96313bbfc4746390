// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/companion_station.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "hils/firmware/vehicle_clock.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"

namespace cas::hils {
namespace {

namespace mv = mavlink::common;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr mav::Source kVehicle{1, 1};
constexpr base::RunTime kNow{seconds(7)};

class Companion : public testing::Test {
 protected:
  template <class Message>
  void hear(const Message& message, mav::Source from = kVehicle) {
    mav::Encoder encode(from);
    station_.on_bytes(encode(message), kNow);
  }
  void at_ms(std::uint32_t boot_ms) { hear(mv::LocalPositionNed{.time_boot_ms = boot_ms}); }

  template <class Message>
  std::vector<Message> sent() {
    std::vector<Message> all;
    mav::PacketParser parser(mv::table());
    for (const auto& bytes : packets_) {
      parser.feed(bytes, [&](const mav::PacketView& packet) {
        if (const auto message = mav::decode<Message>(packet)) all.push_back(*message);
      });
    }
    return all;
  }

  std::vector<std::vector<std::uint8_t>> packets_;
  CompanionStation station_{kVehicle, [this](std::span<const std::uint8_t> packet) {
                              packets_.emplace_back(packet.begin(), packet.end());
                            }};
};

TEST_F(Companion, TellsTheOriginUntilTheVehicleKnowsAPlaceOnTheEarth) {
  using F = mv::EstimatorStatusFlags;
  const auto report = [this](F flags) { hear(mv::EstimatorStatus{.flags = flags}); };
  report(F::kPosHorizRel);
  EXPECT_TRUE(sent<mv::SetGpsGlobalOrigin>().empty()) << "nobody asked for it";
  station_.set_origin({.lat_deg = 47.397742, .lon_deg = -8.5, .alt_m = 488});
  report(F::kAttitude);
  EXPECT_TRUE(sent<mv::SetGpsGlobalOrigin>().empty()) << "it has no position yet";
  report(F::kAttitude | F::kPosHorizRel);
  report(F::kAttitude | F::kPosHorizRel | F::kPosHorizAbs);
  const auto origins = sent<mv::SetGpsGlobalOrigin>();
  ASSERT_EQ(origins.size(), 1U);
  EXPECT_EQ(origins[0].target_system, 1);
  EXPECT_EQ(origins[0].latitude, 473'977'420);
  EXPECT_EQ(origins[0].longitude, -85'000'000);
  EXPECT_EQ(origins[0].altitude, 488'000);
}

TEST_F(Companion, SendsFiftySetpointsForEachSecondOfTheVehiclesClock) {
  station_.setpoints().hover({1, 2, -3}, 0.5);
  for (std::uint32_t ms = 1000; ms < 3000; ms += 4) at_ms(ms);
  const auto setpoints = sent<mv::SetPositionTargetLocalNed>();
  EXPECT_NEAR(static_cast<double>(setpoints.size()), 100, 1);
  EXPECT_EQ(setpoints.front().target_system, 1);
  EXPECT_FLOAT_EQ(setpoints.front().y, 2);
  EXPECT_FLOAT_EQ(setpoints.front().yaw, 0.5);
  EXPECT_EQ(static_cast<int>(setpoints.front().type_mask), 0x9C0)
      << "neither acceleration nor yaw rate";
  EXPECT_EQ(station_.setpoints().figures().count, setpoints.size());
}

TEST_F(Companion, HoldsTheSticksByTheVehiclesClock) {
  at_ms(900);
  EXPECT_TRUE(sent<mv::ManualControl>().empty());
  station_.sticks().hold({.pitch = 0.7, .roll = -1, .yaw = 0.25, .climb = -0.5});
  for (std::uint32_t ms = 1000; ms < 3000; ms += 4) at_ms(ms);
  const auto sticks = sent<mv::ManualControl>();
  EXPECT_NEAR(static_cast<double>(sticks.size()), 50, 1);
  EXPECT_EQ(sticks.front().target, 1);
  EXPECT_EQ(packets_.front()[5], 255) << "ArduPilot takes no other system's";
  EXPECT_EQ(packets_.front()[6], 191) << "and the sticks of a person are told from them";
  EXPECT_EQ(sticks.front().x, 700);
  EXPECT_EQ(sticks.front().y, -1000);
  EXPECT_EQ(sticks.front().r, 250);
  EXPECT_EQ(sticks.front().z, 250) << "a quarter of the throttle";
  EXPECT_NEAR(base::to_seconds(station_.sticks().held_for()), 2, 0.05);
  station_.sticks().hold({});
  EXPECT_EQ(station_.sticks().held_for(), base::Duration{});
  for (std::uint32_t ms = 3000; ms < 3600; ms += 4) at_ms(ms);
  station_.sticks().hold({});
  EXPECT_NEAR(base::to_seconds(station_.sticks().held_for()), 0.56, 0.05) << "they rest";
}

TEST_F(Companion, IsSilentWhileTheVehiclesClockStands) {
  station_.setpoints().hover({0, 0, -3}, 0);
  at_ms(1000);
  const std::size_t before = sent<mv::SetPositionTargetLocalNed>().size();
  for (int i = 0; i < 100; ++i) at_ms(1000);
  for (int i = 0; i < 100; ++i) station_.tick(kNow + milliseconds(20 * i));
  EXPECT_EQ(sent<mv::SetPositionTargetLocalNed>().size(), before);
}

TEST_F(Companion, FliesThePatternFromTheMomentItWasToldOf) {
  station_.setpoints().hover({10, 0, -3}, 0);
  at_ms(1000);
  station_.setpoints().fly(fcu::Pattern(fcu::PatternShape::kCircle, 2, 1, 0), seconds(1));
  at_ms(1040);
  const fcu::Pattern pattern(fcu::PatternShape::kCircle, 2, 1, 0);
  at_ms(9000);
  const auto wanted = pattern.at(8, {10, 0, -3}, 0);
  const auto setpoint = sent<mv::SetPositionTargetLocalNed>().back();
  EXPECT_NEAR(setpoint.x, wanted.p_N.x(), 1e-5);
  EXPECT_NEAR(setpoint.vy, wanted.v_N.y(), 1e-5);
  EXPECT_NEAR(std::hypot(setpoint.vx, setpoint.vy), 1, 1e-5) << "at full speed";
}

TEST_F(Companion, CountsAStreamWithAGapFromItsEnd) {
  station_.setpoints().hover({0, 0, -3}, 0);
  for (std::uint32_t ms = 1000; ms <= 1400; ms += 20) at_ms(ms);
  EXPECT_EQ(station_.setpoints().alive_for(), milliseconds(400));
  at_ms(2000);
  EXPECT_EQ(station_.setpoints().alive_for(), milliseconds(0));
  EXPECT_NEAR(station_.setpoints().figures().longest_gap_s, 0.6, 1e-9);
}

TEST_F(Companion, TakesNoOtherVehiclesWord) {
  station_.setpoints().hover({0, 0, -3}, 0);
  hear(mv::LocalPositionNed{.time_boot_ms = 1000}, {2, 1});
  hear(mv::MissionItemReached{.seq = 4}, {2, 1});
  EXPECT_FALSE(station_.vehicle_time());
  EXPECT_FALSE(station_.reached());
  EXPECT_TRUE(sent<mv::SetPositionTargetLocalNed>().empty());
}

TEST_F(Companion, UploadsAMissionAndKnowsTheLastItemReached) {
  station_.upload({mv::MissionItemInt{}, mv::MissionItemInt{}}, kNow);
  hear(mv::MissionItemReached{.seq = 9});  // of the mission before
  for (std::uint16_t seq = 0; seq < 2; ++seq) {
    hear(mv::MissionRequestInt{.target_system = 253, .target_component = 191, .seq = seq});
  }
  EXPECT_FALSE(station_.uploaded());
  hear(mv::MissionAck{.target_system = 253, .target_component = 191});
  ASSERT_TRUE(station_.uploaded());
  EXPECT_TRUE(station_.uploaded()->ok()) << station_.uploaded()->message;
  EXPECT_FALSE(station_.reached());
  hear(mv::MissionItemReached{.seq = 1});
  hear(mv::MissionItemReached{.seq = 0});
  EXPECT_EQ(station_.reached(), 1U);
}

TEST(VehicleClock, TakesTheLeastLateOfItsLooks) {
  VehicleClock clock;
  clock.add(seconds(1), base::SimTime(milliseconds(11'200)));
  clock.add(seconds(2), base::SimTime(milliseconds(12'050)));
  clock.add(seconds(3), base::SimTime(milliseconds(13'900)));
  EXPECT_EQ(clock.to_sim(seconds(4)), base::SimTime(milliseconds(14'050)));
}

}  // namespace
}  // namespace cas::hils
