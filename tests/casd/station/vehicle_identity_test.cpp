// SPDX-License-Identifier: BSD-3-Clause
// Which HEARTBEATs make a vehicle, whose packets count as its own, and when there are two of one
// id.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "casd/station/vehicle_commander.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;

constexpr Origin kLine{{0}};
constexpr Origin kNet{{1, 1}};
constexpr Origin kOtherPeer{{1, 2}};
constexpr Origin kGroupA{{2}, 0};
constexpr Origin kGroupB{{3, 1}, 0};
constexpr Origin kGroupBOther{{3, 2}, 0};

constexpr MavModeFlag kHil = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
constexpr MavModeFlag kNoHil = MavModeFlag::kCustomModeEnabled;

/// A commander; HEARTBEATs from anywhere; its commands, with their paths.
class Identity : public testing::Test {
 protected:
  struct Sent {
    CommandLong command;
    std::vector<Path> to;
  };

  Identity()
      : commander_({.heartbeat_hz = 0, .ask_on_sight = false},
                   [this](std::span<const std::uint8_t> bytes, std::span<const Path> to) {
                     if (const auto command = mav::decode<CommandLong>(mav::view_packet(bytes))) {
                       sent_.push_back({*command, {to.begin(), to.end()}});
                     }
                   }) {
    commander_.on_notice([this](const std::string& notice) { notices_.push_back(notice); });
  }

  template <class M>
  void hear(const Origin& from, mav::Source source, const M& message) {
    mav::PacketBuffer packet;
    packet.size = mav::encode(message, source, sequence_++, packet.bytes);
    commander_.on_packet(from, mav::view_packet(packet.view()), now_);
  }
  void beat(const Origin& from, MavModeFlag mode, mav::Source source = {1, 1},
            MavAutopilot autopilot = MavAutopilot::kPx4) {
    Heartbeat heartbeat{.type = MavType::kQuadrotor, .autopilot = autopilot, .base_mode = mode};
    hear(from, source, heartbeat);
  }
  void acknowledge(const Origin& from, mav::Source source = {1, 1}) {
    CommandAck ack{.command = MavCmd::kComponentArmDisarm, .result = MavResult::kAccepted};
    hear(from, source, ack);
  }
  void pass(base::Duration time) {
    now_ += time;
    commander_.tick(now_);
  }
  void arm(VehicleCommander::ArmOptions options = {}) {
    outcome_.reset();
    commander_.arm(1, options, now_, [this](const Outcome& outcome) {
      EXPECT_FALSE(outcome_.has_value()) << "a request ended twice";
      outcome_ = outcome;
    });
  }
  void expect_refused(const std::string& word) {
    arm();
    ASSERT_TRUE(outcome_.has_value());
    EXPECT_EQ(outcome_->kind, OutcomeKind::kInterlock);
    EXPECT_NE(outcome_->message.find(word), std::string::npos) << outcome_->message;
    EXPECT_TRUE(sent_.empty());
  }

  base::RunTime now_{100s};
  std::uint8_t sequence_ = 0;
  std::vector<Sent> sent_;
  std::vector<std::string> notices_;
  std::optional<Outcome> outcome_;
  VehicleCommander commander_;
};

TEST_F(Identity, TwoLinksWithOneIdAreTwoAutopilotsWhicheverSpokeFirst) {
  for (const auto& [first, second] : {std::pair{kNoHil, kHil}, std::pair{kHil, kNoHil}}) {
    beat(kLine, first);
    beat(kNet, second);
    expect_refused("not alone");
    beat(kLine, first);
    expect_refused("not alone");
    pass(61s);
    EXPECT_TRUE(commander_.vehicles().empty());
  }
}

TEST_F(Identity, RivalsThatComeAndGoFillNoLogAndHideNoOtherVehicles) {
  for (int i = 0; i < 100; ++i) {
    for (int beats = 0; beats < 5; ++beats, pass(50ms)) beat(kLine, kHil, {7, 1});
    beat(kNet, kHil, {7, 1});
    for (int beats = 0; beats < 4; ++beats, pass(1s)) beat(kLine, kHil, {7, 1});
  }
  EXPECT_LE(notices_.size(), 8U * 10U) << "in seven minutes";
  EXPECT_NE(notices_.at(9).find("no more notices of it for a minute"), std::string::npos);
  notices_.clear();
  beat(kLine, kHil, {1, 1});
  beat(kNet, kHil, {1, 1});
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_NE(notices_[0].find("vehicle 1 has a rival"), std::string::npos);
}

TEST_F(Identity, HangsOnALinkThatNoOtherOneHasHeardOfLate) {
  beat(kGroupA, kHil);
  beat(kGroupB, kHil);
  const VehicleState& vehicle = *commander_.find(1);
  EXPECT_FALSE(vehicle.hangs_on(2, now_));
  EXPECT_FALSE(vehicle.hangs_on(3, now_));
  pass(2s);
  beat(kGroupA, kHil);
  pass(2s);
  EXPECT_TRUE(vehicle.hangs_on(2, now_)) << "the other one is silent";
  EXPECT_FALSE(vehicle.hangs_on(3, now_));
  EXPECT_FALSE(vehicle.hangs_on(0, now_)) << "it was never there";
}

TEST_F(Identity, PeersOfOneLinkAreTwoAutopilots) {
  beat(kNet, kNoHil);
  beat(kOtherPeer, kHil);
  EXPECT_FALSE(commander_.find(1)->hil());
  expect_refused("another peer of link 1");
}

TEST_F(Identity, ConsentDoesNotTellWhichOfTwoIsMeant) {
  CommanderOptions options{.allow_not_hil = true, .ask_on_sight = false};
  VehicleCommander consenting(options, [](auto, auto) { FAIL(); });
  mav::PacketBuffer packet;
  packet.size = mav::encode(Heartbeat{.autopilot = MavAutopilot::kPx4}, {1, 1}, 0, packet.bytes);
  for (const Origin& from : {kLine, kNet}) {
    consenting.on_packet(from, mav::view_packet(packet.view()), now_);
  }
  consenting.arm(1, {.not_hil = true}, now_, [&](const Outcome& o) { outcome_ = o; });
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kInterlock);
}

TEST_F(Identity, AloneAgainItIsArmedByItsOwnHeartbeatOverItsOwnPath) {
  beat(kLine, kHil);
  beat(kNet, kHil);
  ASSERT_EQ(notices_.size(), 1U);
  for (int i = 0; i < 4; ++i) {
    pass(1s);
    beat(kLine, kHil);
  }
  ASSERT_EQ(notices_.size(), 2U) << "once each";
  arm();
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].to, std::vector<Path>{kLine.path});
  acknowledge(kNet);
  EXPECT_FALSE(outcome_.has_value()) << "another one's acknowledgement";
  acknowledge(kLine);
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_TRUE(outcome_->ok());
}

TEST_F(Identity, TheOneThatStillSpeaksTakesThePlaceAndNothingIsBelievedOfTheOther) {
  beat(kNet, kHil);
  arm();
  EXPECT_EQ(sent_.size(), 1U);
  now_ += 3100ms;
  beat(kLine, kNoHil);
  ASSERT_TRUE(outcome_.has_value()) << "what was under way has ended";
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
  sent_.clear();
  EXPECT_EQ(commander_.find(1)->link(), kLine.path.link);
  expect_refused("does not say that it is in HIL");
}

TEST_F(Identity, TheLinksOfAGroupAreOnePlace) {
  beat(kGroupA, kHil);
  pass(1s);
  beat(kGroupB, kHil);
  EXPECT_FALSE(commander_.find(1)->rival(now_));
  EXPECT_EQ(commander_.find(1)->link(), kGroupA.path.link);
  arm();
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].to, (std::vector<Path>{kGroupA.path, kGroupB.path}));
  acknowledge(kGroupB);
  EXPECT_TRUE(outcome_.has_value() && outcome_->ok());
  pass(3s);
  beat(kGroupB, kHil);
  EXPECT_EQ(commander_.find(1)->link(), kGroupB.path.link) << "the first way is silent";
}

TEST_F(Identity, InAGroupEachHeartbeatMustSayHilAndEachLinkHasOnePeer) {
  beat(kGroupA, kNoHil);
  beat(kGroupB, kHil);
  expect_refused("within the last 3 s");
  beat(kGroupBOther, kHil);
  expect_refused("not alone");
}

TEST_F(Identity, TheInterlockIsAskedBeforeEachRepetition) {
  beat(kLine, kHil);
  arm();
  EXPECT_EQ(sent_.size(), 1U);
  beat(kLine, kNoHil);
  pass(1s);
  pass(50ms);
  EXPECT_EQ(sent_.size(), 1U);
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kInterlock);
}

TEST_F(Identity, OnlyAnAutopilotsHeartbeatMakesAVehicle) {
  beat(kLine, kHil, {1, 2}, MavAutopilot::kGeneric);
  beat(kLine, kHil, {1, 1}, MavAutopilot::kInvalid);
  EXPECT_TRUE(commander_.vehicles().empty());
  beat(kLine, kNoHil, {1, 1}, MavAutopilot::kGeneric);
  EXPECT_EQ(commander_.vehicles().size(), 1U);
  beat(kLine, kHil, {1, 1}, MavAutopilot::kInvalid);
  EXPECT_FALSE(commander_.find(1)->hil()) << "not the autopilot's";
}

TEST_F(Identity, ComponentOneDisplacesAnyOther) {
  beat(kLine, kHil, {1, 2});
  EXPECT_EQ(commander_.find(1)->source().component, 2);
  beat(kLine, kHil);
  beat(kLine, kHil, {1, 2});
  EXPECT_EQ(commander_.find(1)->source().component, 1);
  arm();
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].command.target_component, 1);
}

TEST_F(Identity, ComponentOneElsewhereDisplacesButTheOtherStaysItsRival) {
  beat(kLine, kNoHil, {1, 2});
  beat(kNet, kHil);
  EXPECT_EQ(commander_.find(1)->source().component, 1);
  expect_refused("not alone");
}

TEST_F(Identity, ASilentVehicleIsForgottenWhenItIsDisarmed) {
  beat(kLine, kHil);
  beat(kLine, kHil | MavModeFlag::kSafetyArmed, {2, 1});
  pass(61s);
  EXPECT_EQ(commander_.find(1), nullptr);
  EXPECT_NE(commander_.find(2), nullptr);
}

TEST_F(Identity, AFloodOfIdsCostsItsOwnLinkOnly) {
  for (int system = 2; system <= 255; ++system) {
    beat(kNet, kHil | MavModeFlag::kSafetyArmed, {static_cast<std::uint8_t>(system), 1});
  }
  EXPECT_EQ(commander_.vehicles().size(), 250U);
  beat(kLine, kHil);
  EXPECT_NE(commander_.find(1), nullptr);
  pass(61s);
  beat(kNet, kHil, {250, 1});
  EXPECT_NE(commander_.find(250), nullptr) << "armed ones make room where it is needed";
}

TEST_F(Identity, AVehicleOfALinkThatIsGoneIsForgottenAndItsRequestsEnd) {
  beat(kLine, kHil);
  arm();
  commander_.forget(bit(kLine.path.link));
  EXPECT_TRUE(commander_.vehicles().empty());
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
}

}  // namespace
}  // namespace cas::casd
