// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/mission_exchange.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "mavlink/common/mission_request.hpp"
#include "mavlink_gen/runtime/encode.hpp"

namespace cas::mav::services {
namespace {

using namespace std::chrono_literals;
using namespace mavlink::common;

constexpr Source kThisStation{255, 190};

/// A transfer with a vehicle that the test plays, on a virtual clock.
class Mission : public testing::Test {
 protected:
  static MissionExchange::Items items(std::size_t count) {
    MissionExchange::Items items(count);
    for (std::size_t i = 0; i < count; ++i) items[i].x = static_cast<std::int32_t>(1000 + i);
    return items;
  }
  MissionExchange::Done done() {
    return [this](const Outcome& outcome, const MissionExchange::Items& items) {
      outcome_ = outcome;
      items_ = items;
    };
  }
  template <class M>
  void say(M message, Source to = kThisStation) {
    message.target_system = to.system;
    message.target_component = to.component;
    exchange_.on_packet(view_packet(encode_packet_(message)), kThisStation, now_);
  }
  void request(std::uint16_t seq) { say(MissionRequestInt{.seq = seq}); }
  void count(std::uint16_t number) { say(MissionCount{.count = number}); }
  void item(std::uint16_t seq) { say(MissionItemInt{.seq = seq, .x = 1000 + seq}); }
  void acknowledge(MavMissionResult result) { say(MissionAck{.type = result}); }
  void pass(Duration time) {
    now_ += time;
    exchange_.tick(now_);
  }
  template <class M>
  M last() {
    return std::get<M>(sent_.back());
  }

  Time now_{1s};
  Encoder encode_packet_{{.system = 1, .component = 1}};
  MissionExchange::Items items_;
  std::optional<Outcome> outcome_;
  std::vector<MissionExchange::Message> sent_;
  MissionExchange exchange_{[this](const auto& message) { sent_.push_back(message); }};
};

TEST_F(Mission, GoesUpItemByItemAsTheVehicleAsks) {
  exchange_.upload(items(2), now_, done());
  EXPECT_EQ(last<MissionCount>().count, 2);
  request(0);
  EXPECT_EQ(last<MissionItemInt>().seq, 0);
  say(MissionRequest{.seq = 1});
  EXPECT_EQ(last<MissionItemInt>().seq, 1);
  EXPECT_EQ(last<MissionItemInt>().x, 1001);
  EXPECT_FALSE(outcome_);
  acknowledge(MavMissionResult::kAccepted);
  ASSERT_TRUE(outcome_);
  EXPECT_TRUE(outcome_->ok());
  EXPECT_FALSE(exchange_.busy());
}

TEST_F(Mission, AskedAgainForAnItemItGoesAgain) {
  exchange_.upload(items(2), now_, done());
  request(0);
  request(0);
  EXPECT_EQ(last<MissionItemInt>().seq, 0);
  request(1);
  EXPECT_EQ(last<MissionItemInt>().seq, 1);
}

TEST_F(Mission, WithoutAnAnswerIsSentAgainAndGivenUp) {
  exchange_.upload(items(2), now_, done());
  request(0);
  sent_.clear();
  for (int i = 0; i < 10; ++i) pass(700ms);
  EXPECT_EQ(sent_.size(), 4U) << "five tries of the item";
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
  EXPECT_EQ(outcome_->message, "the vehicle asked for 1 of 2 items, then nothing more came");
}

TEST_F(Mission, ThatTheVehicleDoesNotTakeIsRefused) {
  exchange_.upload(items(2), now_, done());
  acknowledge(MavMissionResult::kNoSpace);
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome_->message, "the vehicle asked for 0 of 2 items: no space");
}

TEST_F(Mission, AcceptedBeforeItIsWholeIsRefused) {
  exchange_.upload(items(2), now_, done());
  request(0);
  acknowledge(MavMissionResult::kAccepted);
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused);
}

TEST_F(Mission, ComesDownWholeAndIsAcknowledged) {
  exchange_.download(now_, done());
  pass(700ms);  // the question was lost
  ASSERT_EQ(sent_.size(), 2U);
  count(2);
  EXPECT_EQ(last<MissionRequestInt>().seq, 0);
  item(0);
  item(0);  // an old answer
  EXPECT_EQ(last<MissionRequestInt>().seq, 1);
  pass(700ms);  // lost again
  item(1);
  EXPECT_EQ(last<MissionAck>().type, MavMissionResult::kAccepted);
  ASSERT_TRUE(outcome_);
  EXPECT_TRUE(outcome_->ok());
  ASSERT_EQ(items_.size(), 2U);
  EXPECT_EQ(items_[1].x, 1001);
}

TEST_F(Mission, OfNoItemsComesDownAtOnce) {
  exchange_.download(now_, done());
  count(0);
  ASSERT_TRUE(outcome_);
  EXPECT_TRUE(outcome_->ok());
}

TEST_F(Mission, HearsNothingThatIsForAnotherStation) {
  exchange_.upload(items(1), now_, done());
  MissionAck ack;
  say(ack, {7, 1});
  EXPECT_FALSE(outcome_);
}

TEST_F(Mission, TakesNoFenceForItself) {
  exchange_.download(now_, done());
  say(MissionCount{.count = 3, .mission_type = MavMissionType::kFence});
  EXPECT_EQ(sent_.size(), 1U);
}

TEST_F(Mission, HasOneTransferAtATime) {
  exchange_.download(now_, done());
  std::optional<Outcome> second;
  exchange_.clear(now_, [&](const Outcome& outcome, const auto&) { second = outcome; });
  ASSERT_TRUE(second);
  EXPECT_EQ(second->kind, OutcomeKind::kRefused);
  EXPECT_FALSE(outcome_);
}

}  // namespace
}  // namespace cas::mav::services
