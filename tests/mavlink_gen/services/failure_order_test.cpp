// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/failure_order.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::mav::services {
namespace {

using namespace mavlink::common;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(FailureOrder, ComesBackFromTheWireAsItWasSent) {
  const FailureOrder order{FailureUnit::kMotor, FailureType::kStuck, 3};
  Encoder encoder({255, 190});
  const PacketView packet = view_packet(encoder(command_of(order, {1, 200})));
  const auto command = failure_command(packet);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->order, order);
  EXPECT_EQ(command->target, (Source{1, 200}));
}

TEST(FailureOrder, IsReadFromThePlacedCommandToo) {
  CommandInt placed{.command = MavCmd::kInjectFailure, .param1 = 4, .param2 = 1};
  Encoder encoder({255, 190});
  const auto command = failure_command(view_packet(encoder(placed)));
  ASSERT_TRUE(command);
  EXPECT_EQ(command->order, (FailureOrder{FailureUnit::kGps, FailureType::kOff}));
}

TEST(FailureOrder, IsNoOtherCommand) {
  CommandLong arm{.command = MavCmd::kComponentArmDisarm};
  Encoder encoder({255, 190});
  EXPECT_FALSE(failure_command(view_packet(encoder(arm))));
  EXPECT_FALSE(failure_command(view_packet(encoder(Heartbeat{}))));
}

TEST(FailureOrder, HasWholeNumbersThatAByteHolds) {
  EXPECT_EQ(failure_order(4, 1, kNan), (FailureOrder{FailureUnit::kGps, FailureType::kOff}));
  for (const float wrong : {-1.0F, 0.5F, 256.0F, 1e9F, std::numeric_limits<float>::infinity()}) {
    EXPECT_FALSE(failure_order(wrong, 1, 0)) << wrong;
    EXPECT_FALSE(failure_order(4, wrong, 0)) << wrong;
    EXPECT_FALSE(failure_order(4, 1, wrong)) << wrong;
  }
  EXPECT_FALSE(failure_order(kNan, 1, 0));
  EXPECT_FALSE(failure_order(4, kNan, 0));
}

TEST(FailureOrder, HasTheWordsOfPx4sCommand) {
  EXPECT_EQ(to_words(FailureOrder{FailureUnit::kGps, FailureType::kOff}), "gps off");
  EXPECT_EQ(to_words(FailureOrder{FailureUnit::kMotor, FailureType::kOk, 2}),
            "motor ok, instance 2");
  EXPECT_EQ(to_words(FailureOrder{static_cast<FailureUnit>(42), static_cast<FailureType>(9)}),
            "number 42 number 9");
}

}  // namespace
}  // namespace cas::mav::services
