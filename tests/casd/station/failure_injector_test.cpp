// SPDX-License-Identifier: BSD-3-Clause
// Who may inject failures, where, and the answers to requests.
#include "casd/station/failure_injector.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "casd/packet/intervention.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;
using mav::services::FailureOrder;
using Unit = mav::services::FailureUnit;
using Type = mav::services::FailureType;
using Verdict = FailureInjector::Verdict;

constexpr mav::Source kSelf{254, 190};
constexpr mav::Source kAsker{255, 190};
constexpr mav::Source kHilsim{1, 200};
constexpr Origin kVehicleLink{{0}};
constexpr Origin kSimulatorLink{{1}};
constexpr Origin kPermitted{{2, 7}};
constexpr Origin kForbidden{{3}};
constexpr FailureOrder kGpsOff{Unit::kGps, Type::kOff};
constexpr MavModeFlag kHil = MavModeFlag::kHilEnabled;

/// An injector, the vehicle 1 and its simulator; sent packets, with their paths.
class FailureInjection : public testing::Test {
 protected:
  struct Sent {
    mav::Source source;
    Path to;
    std::optional<CommandLong> command;
    std::optional<CommandAck> ack;
    std::string text;
  };

  FailureInjection()
      : commander_({.heartbeat_hz = 0, .ask_on_sight = false}, [](auto, auto) {}),
        injector_(
            kSelf, commander_,
            {.send = [this](auto bytes, auto to) { keep(mav::view_packet(bytes), to.front()); },
             .permits = [this](LinkId link) { return permitted_ && link == kPermitted.path.link; },
             .link_name = [](LinkId link) { return "link" + std::to_string(link); },
             .hil_doubt =
                 [this](std::uint8_t system) { return commander_.hil_doubt(system, now_); },
             .simulator = [this](std::uint8_t) { return simulator_; },
             .audit = [this](const std::string& line) { audit_.push_back(line); }}) {}

  void keep(const mav::PacketView& packet, const Path& to) {
    Sent sent{.source = packet.source,
              .to = to,
              .command = mav::decode<CommandLong>(packet),
              .ack = mav::decode<CommandAck>(packet),
              .text = {}};
    if (const auto text = mav::decode<Statustext>(packet)) sent.text = mav::text(text->text);
    sent_.push_back(std::move(sent));
  }
  template <class M>
  Verdict hear(const Origin& from, mav::Source source, const M& message) {
    mav::PacketBuffer packet;
    packet.size = mav::encode(message, source, sequence_++, packet.bytes);
    const mav::PacketView view = mav::view_packet(packet.view());
    commander_.on_packet(from, view, now_);
    return injector_.on_packet(from, view, now_);
  }
  void beat(MavModeFlag mode = kHil) {
    Heartbeat heartbeat{
        .type = MavType::kQuadrotor, .autopilot = MavAutopilot::kPx4, .base_mode = mode};
    hear(kVehicleLink, {1, 1}, heartbeat);
  }
  Verdict ask(const Origin& from, const FailureOrder& order = kGpsOff, mav::Source to = {1, 1}) {
    return hear(from, kAsker, mav::services::command_of(order, to));
  }
  /// The simulator's answer to the newest command that it got.
  void simulator_says(MavResult result, const Origin& from = kSimulatorLink,
                      std::uint8_t reason = 0) {
    CommandAck ack{.command = MavCmd::kInjectFailure, .result = result, .progress = reason};
    for (const Sent& sent : sent_) {
      if (sent.command) ack.result_param2 = static_cast<std::int32_t>(sent.command->param7);
    }
    ack.target_system = kSelf.system;
    ack.target_component = kSelf.component;
    hear(from, kHilsim, ack);
  }
  std::vector<CommandLong> commands() const {
    std::vector<CommandLong> all;
    for (const Sent& sent : sent_) {
      if (sent.command) all.push_back(*sent.command);
    }
    return all;
  }
  /// The one answer there is, which bears the vehicle's ids.
  std::optional<MavResult> result() const {
    std::optional<MavResult> only;
    for (const Sent& sent : sent_) {
      if (!sent.ack) continue;
      EXPECT_FALSE(only) << "answered twice";
      EXPECT_EQ(sent.ack->command, MavCmd::kInjectFailure);
      EXPECT_EQ(sent.ack->target_system, kAsker.system);
      EXPECT_EQ(sent.ack->target_component, kAsker.component);
      EXPECT_EQ(sent.source, (mav::Source{1, 1}));
      only = sent.ack->result;
    }
    return only;
  }

  base::RunTime now_{100s};
  VehicleCommander commander_;
  bool permitted_ = true;
  std::optional<Simulator> simulator_ = Simulator{kHilsim, kSimulatorLink.path};
  std::vector<Sent> sent_;
  std::vector<std::string> audit_;
  FailureInjector injector_;
  std::uint8_t sequence_ = 0;
};

TEST_F(FailureInjection, HasAFailureStrikeInTheSimulatorAndAnswersForTheVehicle) {
  beat();
  EXPECT_EQ(ask(kPermitted), Verdict::kTaken);
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].to, kSimulatorLink.path);
  EXPECT_EQ(sent_[0].source, kSelf);
  ASSERT_TRUE(sent_[0].command);
  EXPECT_EQ(sent_[0].command->target_system, kHilsim.system);
  EXPECT_EQ(sent_[0].command->target_component, kHilsim.component);
  EXPECT_EQ(sent_[0].command->param1, 4);
  EXPECT_EQ(sent_[0].command->param2, 1);
  EXPECT_TRUE(audit_.empty());
  simulator_says(MavResult::kAccepted);
  EXPECT_EQ(result(), MavResult::kAccepted);
  EXPECT_EQ(sent_.back().to, kPermitted.path) << "the asker's own peer";
  ASSERT_EQ(audit_.size(), 1U);
  EXPECT_EQ(audit_[0],
            "255/190 on link link2 MAV_CMD_INJECT_FAILURE 'gps off' vehicle 1: accepted");
  EXPECT_EQ(ask(kPermitted, {Unit::kGps, Type::kOk}, {0, 0}), Verdict::kTaken)
      << "the only vehicle is meant";
}

TEST_F(FailureInjection, TakesThePlacedCommandToo) {
  beat();
  CommandInt command{.target_system = 1,
                     .command = MavCmd::kInjectFailure,
                     .param1 = 101,
                     .param2 = 1,
                     .param3 = 2};
  EXPECT_EQ(hear(kPermitted, kAsker, command), Verdict::kTaken);
  ASSERT_EQ(commands().size(), 1U);
  EXPECT_EQ(commands()[0].param1, 101);
  EXPECT_EQ(commands()[0].param3, 2);
}

struct RefusalCase {
  const char* name;
  Origin from;
  MavModeFlag mode;
  bool simulator;
  FailureOrder order;
  mav::Source to;
  MavResult result;
  const char* text;
};

class Refusal : public FailureInjection, public testing::WithParamInterface<RefusalCase> {};

TEST_P(Refusal, SaysWhyAndReachesNobody) {
  const RefusalCase& test = GetParam();
  beat(test.mode);
  if (!test.simulator) simulator_.reset();
  EXPECT_EQ(ask(test.from, test.order, test.to), Verdict::kRefused);
  EXPECT_TRUE(commands().empty());
  ASSERT_EQ(sent_.size(), 2U);
  EXPECT_EQ(sent_[0].text, test.text);
  ASSERT_TRUE(sent_[1].ack);
  EXPECT_EQ(sent_[1].ack->result, test.result);
  for (const Sent& sent : sent_) EXPECT_EQ(sent.to, test.from.path);
  ASSERT_EQ(audit_.size(), 1U);
  EXPECT_NE(audit_[0].find("MAV_CMD_INJECT_FAILURE"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Cases, Refusal,
                         testing::Values(RefusalCase{"OfALinkThatMayNot",
                                                     kForbidden,
                                                     kHil,
                                                     true,
                                                     kGpsOff,
                                                     {1, 1},
                                                     MavResult::kDenied,
                                                     "casd: this link may not inject failures"},
                                         RefusalCase{"OfAVehicleThatMayBeReal",
                                                     kPermitted,
                                                     MavModeFlag::kCustomModeEnabled,
                                                     true,
                                                     kGpsOff,
                                                     {1, 1},
                                                     MavResult::kDenied,
                                                     "casd: the vehicle is not known to be in HIL"},
                                         RefusalCase{"OfAnUnknownVehicle",
                                                     kPermitted,
                                                     kHil,
                                                     true,
                                                     kGpsOff,
                                                     {9, 1},
                                                     MavResult::kDenied,
                                                     "casd: there is no such vehicle"},
                                         RefusalCase{"WithoutASimulator",
                                                     kPermitted,
                                                     kHil,
                                                     false,
                                                     kGpsOff,
                                                     {1, 1},
                                                     MavResult::kUnsupported,
                                                     "casd: no simulator feeds this vehicle"}),
                         [](const auto& test) { return test.param.name; });

TEST_F(FailureInjection, RefusesWhatIsNoNumber) {
  beat();
  CommandLong command = mav::services::command_of(kGpsOff, {1, 1});
  command.param2 = 1.5F;
  EXPECT_EQ(hear(kPermitted, kAsker, command), Verdict::kRefused);
  EXPECT_TRUE(commands().empty());
  EXPECT_EQ(result(), MavResult::kDenied);
}

TEST_F(FailureInjection, TakesNoAutopilotForASimulator) {
  beat();
  for (const mav::Source source : {mav::Source{1, 1}, {2, 1}}) {
    simulator_->source = source;
    EXPECT_EQ(ask(kPermitted), Verdict::kRefused);
  }
  EXPECT_TRUE(commands().empty());
}

TEST_F(FailureInjection, RefusesAVehicleThatHasFallenSilent) {
  beat();
  now_ += 10s;
  EXPECT_EQ(ask(kPermitted), Verdict::kRefused);
  EXPECT_EQ(result(), MavResult::kDenied);
}

TEST_F(FailureInjection, PassesTheSimulatorsRefusalOn) {
  beat();
  ask(kPermitted);
  simulator_says(MavResult::kUnsupported);
  EXPECT_EQ(result(), MavResult::kUnsupported);
  EXPECT_EQ(sent_[1].text, "casd: the simulator refused the failure");
}

TEST_F(FailureInjection, PassesTheSimulatorsReasonOn) {
  beat();
  std::set<std::string> texts;
  for (std::uint8_t reason = 1; reason <= 6; ++reason) {
    sent_.clear();
    ask(kPermitted);
    simulator_says(MavResult::kUnsupported, kSimulatorLink, reason);
    const std::string text = sent_.at(1).text;
    EXPECT_EQ(text.rfind("casd: ", 0), 0U);
    EXPECT_LE(text.size(), 50U) << text;  // a STATUSTEXT
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), 6U);
  EXPECT_FALSE(texts.contains("casd: the simulator refused the failure"));
}

TEST_F(FailureInjection, BelievesTheSimulatorAlone) {
  beat();
  ask(kPermitted);
  simulator_says(MavResult::kAccepted, kForbidden);
  EXPECT_EQ(result(), std::nullopt);
  EXPECT_EQ(injector_.due(), now_ + FailureInjector::kPatience);
  now_ += FailureInjector::kPatience;
  injector_.tick(now_);
  EXPECT_EQ(result(), MavResult::kFailed);
  EXPECT_EQ(injector_.due(), base::RunTime::max());
  simulator_says(MavResult::kAccepted);  // too late
  EXPECT_EQ(result(), MavResult::kFailed);
}

TEST_F(FailureInjection, SendsARepetitionOnceAndOneFailureAfterTheOther) {
  beat();
  EXPECT_EQ(ask(kPermitted), Verdict::kTaken);
  EXPECT_EQ(ask(kPermitted), Verdict::kRefused) << "it waits for its answer";
  EXPECT_EQ(ask(kPermitted, {Unit::kBaro, Type::kStuck}), Verdict::kTaken);
  EXPECT_EQ(commands().size(), 1U);
  simulator_says(MavResult::kAccepted);
  ASSERT_EQ(commands().size(), 2U);
  EXPECT_EQ(commands()[1].param1, 3);
  EXPECT_NE(commands()[0].param7, commands()[1].param7);
}

TEST_F(FailureInjection, TwoStationsWithOneIdBothGetAnAnswer) {
  beat();
  Origin other = kPermitted;
  other.path.peer += 1;
  EXPECT_EQ(ask(kPermitted), Verdict::kTaken);
  EXPECT_EQ(ask(other), Verdict::kTaken);
  simulator_says(MavResult::kAccepted);
  simulator_says(MavResult::kAccepted);
  std::vector<Path> answered;
  for (const Sent& sent : sent_) {
    if (sent.ack) answered.push_back(sent.to);
  }
  EXPECT_EQ(answered, (std::vector<Path>{kPermitted.path, other.path}));
}

TEST_F(FailureInjection, AsksForHilAgainBeforeTheNextIsSent) {
  beat();
  ask(kPermitted);
  ask(kPermitted, {Unit::kBaro, Type::kStuck});
  beat(MavModeFlag::kCustomModeEnabled);
  simulator_says(MavResult::kAccepted);
  EXPECT_EQ(commands().size(), 1U);
  ASSERT_TRUE(sent_.back().ack);
  EXPECT_EQ(sent_.back().ack->result, MavResult::kDenied);
}

TEST_F(FailureInjection, HoldsAFewAndRefusesMore) {
  beat();
  for (std::uint8_t i = 0; i <= FailureInjector::kMostWaiting; ++i) {
    ask(kPermitted, {Unit::kMotor, Type::kOff, i});
  }
  EXPECT_EQ(result(), MavResult::kTemporarilyRejected);
}

TEST_F(FailureInjection, AnswersNobodyOnALinkThatIsGoneAndDropsWhatWaits) {
  beat();
  ask(kPermitted);
  ask(kPermitted, {Unit::kBaro, Type::kStuck});
  injector_.begin_reload(bit(kPermitted.path.link), now_);
  EXPECT_EQ(audit_.size(), 1U) << "what waited";
  EXPECT_EQ(ask(kPermitted, {Unit::kMag, Type::kOff}), Verdict::kRefused) << "it was on its way";
  EXPECT_EQ(audit_.size(), 2U);
  injector_.end_reload();
  simulator_says(MavResult::kAccepted);
  EXPECT_EQ(result(), std::nullopt);
  EXPECT_EQ(commands().size(), 1U);
  ASSERT_EQ(audit_.size(), 3U);
  EXPECT_NE(audit_[2].find("'gps off' vehicle 1: accepted"), std::string::npos) << audit_[2];
  EXPECT_EQ(ask(kPermitted), Verdict::kTaken) << "a new link with this number";
}

TEST_F(FailureInjection, AsksForThePermissionAgainBeforeTheNextIsSent) {
  beat();
  ask(kPermitted);
  ask(kPermitted, {Unit::kBaro, Type::kStuck});
  permitted_ = false;
  simulator_says(MavResult::kAccepted);
  EXPECT_EQ(commands().size(), 1U);
  EXPECT_EQ(sent_.back().ack->result, MavResult::kDenied);
}

TEST(IsFailure, KnowsTheCommandWithATimeToo) {
  std::array<std::uint8_t, 44> payload{};
  const mav::PacketView packet{.message_id = 224, .payload = payload};
  EXPECT_FALSE(is_failure(packet));
  payload[40] = 0xA4;
  payload[41] = 0x01;
  EXPECT_TRUE(is_failure(packet));
}

TEST_F(FailureInjection, TakesNothingInItsOwnName) {
  beat();
  EXPECT_EQ(hear(kPermitted, kSelf, mav::services::command_of(kGpsOff, {1, 1})), Verdict::kRefused);
  EXPECT_TRUE(commands().empty());
  ASSERT_EQ(audit_.size(), 1U);
  EXPECT_NE(audit_[0].find("the sender has casd's own ids"), std::string::npos) << audit_[0];
}

TEST_F(FailureInjection, LeavesFewLinesOfAFlood) {
  beat();
  for (int i = 0; i < 1000; ++i) ask(kForbidden);
  EXPECT_LE(audit_.size(), 20U);
  EXPECT_FALSE(audit_.empty());
}

TEST_F(FailureInjection, TakesTheCommandPortsOrders) {
  beat();
  const VehicleCommand gps_off{.id = MavCmd::kInjectFailure, .params = {4, 1}};
  std::optional<Outcome> outcome;
  injector_.inject(1, gps_off, now_, [&](const Outcome& told) { outcome = told; });
  EXPECT_EQ(commands().size(), 1U);
  simulator_says(MavResult::kAccepted);
  ASSERT_TRUE(outcome);
  EXPECT_TRUE(outcome->ok());
  beat(MavModeFlag::kCustomModeEnabled);
  injector_.inject(1, gps_off, now_, [&](const Outcome& told) { outcome = told; });
  EXPECT_EQ(outcome->kind, OutcomeKind::kInterlock);
  injector_.inject(1, {.id = MavCmd::kInjectFailure, .params = {4, 1.5F}}, now_,
                   [&](const Outcome& told) { outcome = told; });
  EXPECT_EQ(outcome->kind, OutcomeKind::kInvalid);
  EXPECT_TRUE(audit_.empty()) << "the port leaves a line of its own";
}

}  // namespace
}  // namespace cas::casd
