// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/newest_setpoints.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "casd/packet/setpoint_stream.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/set_attitude_target.hpp"
#include "mavlink/common/set_position_target_local_ned.hpp"
#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using mavlink::common::RcChannelsOverride;

/// A setpoint of a stream.
PacketInfo of_stream(std::uint32_t message_id, std::uint8_t sender = 255) {
  PacketInfo setpoint = info(TrafficClass::kSetpoint, at({}), message_id);
  setpoint.source = {sender, 190};
  setpoint.from = 2;
  return setpoint;
}

class NewestSetpointsTest : public testing::Test {
 protected:
  void push(const PacketInfo& setpoint, std::uint8_t content) {
    waiting.push(setpoint, bytes(20, content), on_drop);
  }
  /// First bytes of the waiting packets.
  std::vector<int> contents() {
    std::vector<int> all;
    while (!waiting.empty()) all.push_back(waiting.pop().bytes.front());
    return all;
  }
  NewestSetpoints waiting;
  int superseded = 0;
  int no_room = 0;
  NewestSetpoints::OnDrop on_drop = [this](const PacketInfo&, DropCause cause) {
    ++(cause == DropCause::kSuperseded ? superseded : no_room);
  };
};

TEST_F(NewestSetpointsTest, NewestOfAStreamWaits) {
  for (std::uint8_t i = 1; i <= 5; ++i) push(of_stream(69), i);
  EXPECT_EQ(contents(), std::vector{5});
  EXPECT_EQ(superseded, 4);
}

TEST_F(NewestSetpointsTest, StreamsTakeTurnsWhateverTheirRatesAre) {
  push(of_stream(69), 1);
  push(of_stream(82), 2);
  push(of_stream(69), 3);
  EXPECT_EQ(contents(), (std::vector{3, 2}));
}

TEST_F(NewestSetpointsTest, MessageSenderTargetAndWayMakeAStream) {
  PacketInfo stick = of_stream(69);
  push(stick, 1);
  push(of_stream(70), 2);
  push(of_stream(69, 254), 3);
  stick.target = {2, 0};
  push(stick, 4);
  stick = of_stream(69);
  stick.from_serial = 7;
  push(stick, 5);
  stick = of_stream(69);
  stick.to_serial = 9;
  push(stick, 6);
  EXPECT_EQ(waiting.count(), 6U);
  EXPECT_EQ(superseded, 0);
}

TEST_F(NewestSetpointsTest, WaysOfAGroupAreOne) {
  PacketInfo stick = of_stream(69);
  stick.from_group = 1;
  push(stick, 1);
  stick.from = 5;
  push(stick, 2);
  EXPECT_EQ(contents(), std::vector{2});
}

TEST_F(NewestSetpointsTest, FloodOfInventedSendersCostsItsOwnWay) {
  PacketInfo pilot = of_stream(69);
  pilot.from = 1;
  push(pilot, 200);
  for (int i = 0; i < 1000; ++i) {
    PacketInfo invented = of_stream(69, static_cast<std::uint8_t>(i % 250));
    invented.source.component = static_cast<std::uint8_t>(i / 250);
    push(invented, 1);
  }
  EXPECT_EQ(waiting.count(), NewestSetpoints::kMaxWaiting);
  EXPECT_GT(no_room, 0);
  EXPECT_EQ(contents().front(), 200);
}

/// RC_CHANNELS_OVERRIDE that leaves all channels but the first two, unless it names them.
mav::PacketBuffer override_of(std::uint16_t first, std::uint16_t second) {
  constexpr std::uint16_t kLeave = std::numeric_limits<std::uint16_t>::max();
  RcChannelsOverride rc{.chan1_raw = first, .chan2_raw = second};
  rc.chan3_raw = rc.chan4_raw = rc.chan5_raw = rc.chan6_raw = rc.chan7_raw = rc.chan8_raw = kLeave;
  return packet(rc, {255, 190});
}

/// Whether the newer one takes the older one's place.
template <class Message>
bool takes_place(const Message& newer, const Message& older) {
  return replaces(of_stream(Message::kId), packet(newer, {255, 190}).view(),
                  packet(older, {255, 190}).view());
}

TEST(SetpointStream, TargetTakesThePlaceOfOneThatNamesNoMore) {
  using mavlink::common::AttitudeTargetTypemask;
  mavlink::common::SetAttitudeTarget all;
  mavlink::common::SetAttitudeTarget thrust_only;
  thrust_only.type_mask = static_cast<AttitudeTargetTypemask>(0b1000'0111);
  mavlink::common::SetAttitudeTarget attitude_only;
  attitude_only.type_mask = static_cast<AttitudeTargetTypemask>(0b0100'0111);
  EXPECT_TRUE(takes_place(all, thrust_only));
  EXPECT_TRUE(takes_place(thrust_only, thrust_only));
  EXPECT_FALSE(takes_place(thrust_only, all));
  EXPECT_FALSE(takes_place(attitude_only, thrust_only));
}

TEST(SetpointStream, TargetInAnotherFrameIsAnother) {
  mavlink::common::SetPositionTargetLocalNed ned;
  ned.coordinate_frame = mavlink::common::MavFrame::kLocalNed;
  mavlink::common::SetPositionTargetLocalNed body = ned;
  body.coordinate_frame = mavlink::common::MavFrame::kBodyNed;
  EXPECT_TRUE(takes_place(ned, ned));
  EXPECT_FALSE(takes_place(body, ned));
}

TEST(SetpointStream, TapOfAButtonIsNotLost) {
  mavlink::common::ManualControl pressed{.buttons = 4};
  const mavlink::common::ManualControl released;
  EXPECT_TRUE(takes_place(released, released));
  EXPECT_FALSE(takes_place(released, pressed));
}

TEST(SetpointStream, GroupsOfActuatorsAreStreams) {
  const auto of_group = [](std::uint8_t group) {
    std::vector<std::uint8_t> bytes(10 + 43 + 2);
    bytes[0] = 0xFD;
    bytes[1] = 43;
    bytes[7] = 139;
    bytes[10 + 40] = group;
    return bytes;
  };
  EXPECT_TRUE(replaces(of_stream(139), of_group(3), of_group(3)));
  EXPECT_FALSE(replaces(of_stream(139), of_group(0), of_group(3)));
}

TEST_F(NewestSetpointsTest, ChannelThatIsGivenBackIsNotLostBehindOthers) {
  constexpr std::uint16_t kLeave = std::numeric_limits<std::uint16_t>::max();
  const PacketInfo rc = of_stream(RcChannelsOverride::kId);
  const auto both = override_of(1500, 1500);
  const auto give_back = override_of(0, kLeave);
  const auto second_only = override_of(kLeave, 1600);
  EXPECT_TRUE(replaces(rc, both.view(), give_back.view()));
  EXPECT_FALSE(replaces(rc, second_only.view(), give_back.view()));

  waiting.push(rc, both.view(), on_drop);
  waiting.push(rc, give_back.view(), on_drop);
  waiting.push(rc, second_only.view(), on_drop);
  EXPECT_EQ(waiting.count(), 3U) << "none says all that another one says";
  const auto newer = override_of(kLeave, 1700);
  waiting.push(rc, newer.view(), on_drop);
  EXPECT_EQ(waiting.count(), 3U);
  EXPECT_EQ(superseded, 1);
  waiting.pop();
  waiting.pop();
  const QueuedPacket last = waiting.pop();
  EXPECT_TRUE(std::equal(last.bytes.begin(), last.bytes.end(), newer.view().begin()))
      << "nothing older comes out behind it";
}

}  // namespace
}  // namespace cas::casd::test
