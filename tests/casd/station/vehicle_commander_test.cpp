// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <vector>

#include "tests/casd/station/commander_fixture.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;
using test::FakeVehicle;
using test::kLink;
using test::VehicleCommanderTest;

TEST_F(VehicleCommanderTest, KnowsAVehicleByItsHeartbeat) {
  EXPECT_TRUE(commander_.vehicles().empty());
  meet();
  ASSERT_NE(commander_.find(1), nullptr);
  EXPECT_EQ(commander_.find(1)->autopilot(), Autopilot::kPx4);
  EXPECT_TRUE(commander_.find(1)->hil());
  EXPECT_FALSE(commander_.find(1)->armed());
  EXPECT_EQ(commander_.find(1)->link(), kLink);
}

TEST_F(VehicleCommanderTest, TakesASimulatorForNoVehicle) {
  vehicle_.autopilot = MavAutopilot::kInvalid;
  meet();
  EXPECT_TRUE(commander_.vehicles().empty());
}

TEST_F(VehicleCommanderTest, SendsOneHeartbeatASecond) {
  commander_.tick(now_);
  run_for(10s);
  EXPECT_NEAR(vehicle_.heartbeats, 10, 1);
}

TEST_F(VehicleCommanderTest, RestsUntilTheHeartbeatIsDue) {
  commander_.tick(now_);
  EXPECT_EQ(commander_.next_tick(now_), now_ + kRestTick);
  EXPECT_EQ(commander_.next_tick(now_ + 900ms), now_ + 1s);
  EXPECT_EQ(commander_.next_tick(now_ + 2s), now_ + 2s);  // late: at once
}

TEST_F(VehicleCommanderTest, RestsNoLongerThanARequestMayWait) {
  commander_.set_commanding(0, false, false);
  meet();
  EXPECT_EQ(commander_.next_tick(now_), now_ + kRestTick);
  vehicle_.script.deaf_for = 1;
  commander_.arm(1, {}, now_, done());
  const base::RunTime repeats = now_ + CommandTiming{}.ack_timeout;
  EXPECT_EQ(commander_.next_tick(now_ + 600ms), repeats);
  EXPECT_TRUE(finish().ok());
  EXPECT_EQ(commander_.next_tick(now_), now_ + kRestTick);
}

TEST_F(VehicleCommanderTest, ResolvesTheOnlyVehicle) {
  EXPECT_EQ(std::get<Outcome>(commander_.resolve({})).kind, OutcomeKind::kNoSuchVehicle);
  meet();
  EXPECT_EQ(std::get<std::uint8_t>(commander_.resolve({})), 1);
  EXPECT_EQ(std::get<Outcome>(commander_.resolve(7)).kind, OutcomeKind::kNoSuchVehicle);
}

TEST_F(VehicleCommanderTest, AsksForTheVehicleWhenThereAreTwo) {
  meet();
  FakeVehicle second({2, 1});
  second.say_heartbeat(now_);
  parser_.feed(second.take(now_)->view(), [this](const mav::PacketView& packet) {
    commander_.on_packet(kLink, packet, now_);
  });
  EXPECT_EQ(std::get<Outcome>(commander_.resolve({})).kind, OutcomeKind::kInvalid);
  EXPECT_EQ(std::get<std::uint8_t>(commander_.resolve(2)), 2);
}

TEST_F(VehicleCommanderTest, RemembersTheNewestTenStatusTexts) {
  meet();
  for (int i = 0; i < 15; ++i) vehicle_.say_text("text " + std::to_string(i), now_);
  run_for(50ms);
  const auto& texts = commander_.find(1)->status_texts();
  ASSERT_EQ(texts.size(), 10U);
  EXPECT_EQ(texts.back().text, "text 14");
}

TEST_F(VehicleCommanderTest, JoinsAStatusTextInChunks) {
  meet();
  Statustext chunk{.id = 7};
  std::string text(50, 'a');
  mav::set_text(chunk.text, text);
  vehicle_.say(chunk, now_);
  chunk.chunk_seq = 1;
  mav::set_text(chunk.text, "b");
  say(chunk);
  ASSERT_EQ(commander_.find(1)->status_texts().size(), 1U);
  text += 'b';
  EXPECT_EQ(commander_.find(1)->status_texts()[0].text, text);
}

TEST_F(VehicleCommanderTest, NeverHoldsMoreVehiclesThanItsBound) {
  for (int system = 1; system <= 255; ++system) {
    FakeVehicle one({static_cast<std::uint8_t>(system), 1});
    one.say_heartbeat(now_);
    parser_.feed(one.take(now_)->view(), [this](const mav::PacketView& packet) {
      commander_.on_packet(kLink, packet, now_);
    });
  }
  EXPECT_EQ(commander_.vehicles().size(), 250U);
}

TEST_F(VehicleCommanderTest, AsksANewVehicleForItsVersionHomeAndEstimator) {
  VehicleCommander curious({}, [this](std::span<const std::uint8_t> bytes, std::span<const Path>) {
    parser_.feed(bytes, [this](const mav::PacketView& packet) { vehicle_.handle(packet, now_); });
  });
  vehicle_.say_heartbeat(now_);
  mav::PacketParser parser(mavlink::common::table());
  for (int i = 0; i < 200; ++i, now_ += 5ms) {
    while (const auto packet = vehicle_.take(now_)) {
      parser.feed(packet->view(),
                  [&](const mav::PacketView& view) { curious.on_packet(kLink, view, now_); });
    }
  }
  ASSERT_EQ(vehicle_.commands.size(), 3U);
  EXPECT_EQ(vehicle_.commands[0].param1, 148.0F);
  EXPECT_EQ(vehicle_.commands[1].param1, 230.0F) << "ESTIMATOR_STATUS, each second";
  EXPECT_EQ(vehicle_.commands[2].param1, 242.0F);
}

/// A vehicle gets more rate requests than half of its command queue.
class RequestedRates : public VehicleCommanderTest {
 protected:
  RequestedRates()
      : VehicleCommanderTest({.request_rates = [](LinkId) {
          std::vector<MessageRate> rates;
          for (std::uint32_t id = 1; id <= 40; ++id) rates.push_back({id, 10});
          return rates;
        }}) {
    commander_.on_notice([this](const std::string& notice) { notices_.push_back(notice); });
  }
  void tell_time(std::uint32_t ms) { say(mavlink::common::Attitude{.time_boot_ms = ms}); }
  /// The messages whose rates were asked for, in that order, each once.
  std::vector<std::uint32_t> asked() const {
    std::vector<std::uint32_t> ids;
    for (const auto& command : vehicle_.commands) {
      if (command.command != mavlink::common::MavCmd::kSetMessageInterval) continue;
      const auto id = static_cast<std::uint32_t>(command.param1);
      if (ids.empty() || ids.back() != id) ids.push_back(id);
    }
    return ids;
  }
  std::vector<std::string> notices_;
};

TEST_F(RequestedRates, ARestartBeginsThemAnewAndLeavesNothingInTheQueue) {
  meet();
  vehicle_.script.answers = 0;
  tell_time(100'000);
  for (std::uint32_t restart = 1; restart <= 3; ++restart) {
    run_for(std::chrono::seconds(4));
    tell_time(100'000 - 10'000 * restart);
  }
  vehicle_.commands.clear();
  vehicle_.script.answers = 1;
  run_for(std::chrono::seconds(20));
  const auto ids = asked();
  const auto first = std::ranges::find(ids, 1U);
  ASSERT_NE(first, ids.end());
  EXPECT_LE(first - ids.begin(), 1) << "one may be under way";
  EXPECT_EQ(ids.end() - first, 40);
  EXPECT_EQ(ids.back(), 40U);
  EXPECT_TRUE(notices_.empty()) << notices_.front();
}

TEST_F(RequestedRates, WhatIsRefusedIsToldInOneNotice) {
  vehicle_.script.result = mavlink::common::MavResult::kDenied;
  meet();
  run_for(std::chrono::seconds(60));
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_TRUE(notices_[0].starts_with("vehicle 1 does not send message 1 at 10 Hz: "))
      << notices_[0];
  EXPECT_NE(notices_[0].find("; nor message 40 at 10 Hz: "), std::string::npos) << notices_[0];
}

}  // namespace
}  // namespace cas::casd
