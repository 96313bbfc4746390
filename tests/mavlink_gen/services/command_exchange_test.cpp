// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/command_exchange.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <vector>

namespace cas::mav::services {
namespace {

using namespace std::chrono_literals;
using mavlink::common::CommandAck;
using mavlink::common::CommandInt;
using mavlink::common::CommandLong;
using mavlink::common::MavCmd;
using mavlink::common::MavResult;

/// An exchange with a vehicle that the test plays, on a virtual clock.
class Command : public testing::Test {
 protected:
  void start(const VehicleCommand& command) {
    exchange_.start(command, now_,
                    [this](const Outcome& outcome) { outcomes_.push_back(outcome); });
  }
  void acknowledge(MavCmd id, MavResult result) {
    exchange_.on_ack(CommandAck{.command = id, .result = result}, now_);
  }
  void pass(Duration time) {
    now_ += time;
    exchange_.tick(now_);
  }

  Time now_{1s};
  std::vector<CommandExchange::Message> sent_;
  CommandExchange exchange_{[this](const auto& message) { sent_.push_back(message); }};
  std::vector<Outcome> outcomes_;
};

TEST_F(Command, IsRepeatedWithARisingConfirmationAndGivenUp) {
  start(request_command(148));
  for (int i = 0; i < 10; ++i) pass(700ms);
  ASSERT_EQ(sent_.size(), 5U);
  for (std::size_t i = 0; i < sent_.size(); ++i) {
    EXPECT_EQ(std::get<CommandLong>(sent_[i]).confirmation, i);
    EXPECT_EQ(std::get<CommandLong>(sent_[i]).param1, 148);
  }
  ASSERT_EQ(outcomes_.size(), 1U);
  EXPECT_EQ(outcomes_[0].kind, OutcomeKind::kTimeout);
}

TEST_F(Command, IsDueAtItsDeadlineAndNeverOnceItHasEnded) {
  EXPECT_EQ(exchange_.due(), std::nullopt);
  start(request_command(148));
  EXPECT_EQ(exchange_.due(), now_ + 700ms);
  start(request_command(242));  // waits for the one before
  EXPECT_EQ(exchange_.due(), now_ + 700ms);
  exchange_.give_up(Outcome{});
  EXPECT_EQ(exchange_.due(), std::nullopt);
}

TEST_F(Command, InProgressWaitsAndIsNotRepeated) {
  start(arm_command(true, false));
  acknowledge(MavCmd::kComponentArmDisarm, MavResult::kInProgress);
  pass(9s);
  EXPECT_EQ(sent_.size(), 1U);
  EXPECT_TRUE(outcomes_.empty());
  acknowledge(MavCmd::kComponentArmDisarm, MavResult::kAccepted);
  ASSERT_EQ(outcomes_.size(), 1U);
  EXPECT_TRUE(outcomes_[0].ok());
}

TEST_F(Command, ARefusalWaitsForTheTextThatSaysWhy) {
  start(arm_command(true, false));
  acknowledge(MavCmd::kComponentArmDisarm, MavResult::kDenied);
  exchange_.on_status_text("PreArm: compass");
  EXPECT_TRUE(outcomes_.empty());
  pass(250ms);
  ASSERT_EQ(outcomes_.size(), 1U);
  EXPECT_EQ(outcomes_[0].message, "MAV_CMD 400 (arm or disarm) was denied: PreArm: compass");
}

TEST_F(Command, OneWithAPlaceIsACommandInt) {
  VehicleCommand command{.id = MavCmd::kDoReposition};
  command.place = VehicleCommand::Place{.lat_deg_e7 = 473'977'420, .lon_deg_e7 = 1, .alt_m = 500};
  start(command);
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(std::get<CommandInt>(sent_[0]).x, 473'977'420);
}

TEST_F(Command, ASecondOfItsIdWaitsInLine) {
  start(request_command(148));
  start(request_command(242));
  EXPECT_EQ(sent_.size(), 1U);
  acknowledge(MavCmd::kRequestMessage, MavResult::kAccepted);
  ASSERT_EQ(sent_.size(), 2U);
  EXPECT_EQ(std::get<CommandLong>(sent_[1]).param1, 242);
}

TEST(CommandTime, MayBeThatOfAnyClock) {
  const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
  const Time time = now;
  EXPECT_EQ(time.time_since_epoch(), now.time_since_epoch());
  EXPECT_EQ(time - Time(now - 3ms), 3ms);
}

}  // namespace
}  // namespace cas::mav::services
