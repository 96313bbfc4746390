// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/param_exchange.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {
namespace {

using namespace std::chrono_literals;
using base::RunTime;
using mavlink::common::MavParamType;
using mavlink::common::ParamRequestRead;
using mavlink::common::ParamValue;

/// An exchange with a vehicle that the test plays, on a virtual clock.
class ParamList : public testing::Test {
 protected:
  void list() {
    exchange_.list(now_, [this](const Outcome& outcome) { outcome_ = outcome; });
  }
  void answer(const std::string& name, std::uint16_t index, std::uint16_t count) {
    ParamValue value;
    mav::set_text(value.param_id, name);
    value.param_type = MavParamType::kReal32;
    value.param_index = index;
    value.param_count = count;
    exchange_.on_value(value, ParamEncoding::kBytewise, now_);
  }
  void pass(base::Duration time) {
    now_ += time;
    exchange_.tick(now_);
  }

  RunTime now_{1s};
  int reads_ = 0;
  ParamExchange exchange_{[this](const ParamExchange::Message& message) {
    if (std::holds_alternative<ParamRequestRead>(message)) ++reads_;
  }};
  std::optional<Outcome> outcome_;
};

TEST_F(ParamList, OfAVehicleThatAnswersOneAtATimeEndsAtItsDeadline) {
  list();
  const RunTime start = now_;
  for (std::uint16_t index = 0; index < 8000 && !outcome_; ++index) {
    answer("P" + std::to_string(index), index, 8000);
    pass(500ms);
  }
  ASSERT_TRUE(outcome_.has_value()) << "it would have gone on for more than an hour";
  EXPECT_LE(now_ - start, 121s);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
  EXPECT_NE(outcome_->message.find("of 8000 parameters in 120 s"), std::string::npos)
      << outcome_->message;
  EXPECT_GT(outcome_->parameters.size(), 200U) << "what came is not lost";
}

TEST_F(ParamList, OfAnAbsurdCountIsRefusedAtOnce) {
  list();
  answer("P0", 0, 65535);
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused);
  EXPECT_NE(outcome_->message.find("65535 parameters"), std::string::npos) << outcome_->message;
}

TEST_F(ParamList, OfNamesWithoutEndIsRefused) {
  list();
  for (int i = 0; i < 10'000 && !outcome_; ++i) answer("N" + std::to_string(i), 0, 2);
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome_->parameters.size(), 8192U);
}

TEST_F(ParamList, OfACountThatChangesWithEachAnswerEnds) {
  list();
  const RunTime start = now_;
  for (std::uint16_t i = 0; i < 1000 && !outcome_; ++i) {
    answer("P" + std::to_string(i % 7), 0, static_cast<std::uint16_t>(100 + i % 3));
    pass(100ms);
  }
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_FALSE(outcome_->ok());
  EXPECT_LE(now_ - start, 121s);
}

TEST_F(ParamList, IsAskedForByABoundedNumberOfClients) {
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    exchange_.list(now_, [&](const Outcome& outcome) {
      if (outcome.kind == OutcomeKind::kRefused) ++refused;
    });
  }
  EXPECT_EQ(refused, 36);
}

}  // namespace
}  // namespace cas::casd
