// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/param_exchange.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "mavlink_gen/runtime/codec.hpp"

namespace cas::mav::services {
namespace {

using namespace std::chrono_literals;
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
    set_text(value.param_id, name);
    value.param_type = MavParamType::kReal32;
    value.param_index = index;
    value.param_count = count;
    exchange_.on_value(value, ParamEncoding::kBytewise, now_);
  }
  void pass(Duration time) {
    now_ += time;
    exchange_.tick(now_);
  }

  Time now_{1s};
  int reads_ = 0;
  ParamExchange exchange_{[this](const ParamExchange::Message& message) {
    if (std::holds_alternative<ParamRequestRead>(message)) ++reads_;
  }};
  std::optional<Outcome> outcome_;
};

TEST_F(ParamList, OfASlowLineTakesAsLongAsParametersCome) {
  list();
  for (std::uint16_t index = 0; index < 1300; ++index) {
    ASSERT_FALSE(outcome_.has_value()) << index;
    pass(500ms);
    answer("P" + std::to_string(index), index, 1300);
  }
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_TRUE(outcome_->ok()) << outcome_->message;
  EXPECT_EQ(outcome_->parameters.size(), 1300U);
}

TEST_F(ParamList, OutlivesAGapOfSecondsAndTellsHowFarItIs) {
  list();
  EXPECT_EQ(exchange_.list_progress()->count, 0U);
  answer("P0", 0, 2);
  for (int i = 0; i < 9; ++i) pass(1s);
  ASSERT_FALSE(outcome_.has_value()) << outcome_->message;
  EXPECT_EQ(exchange_.list_progress()->received, 1U);
  EXPECT_EQ(exchange_.list_progress()->count, 2U);
  answer("P1", 1, 2);
  EXPECT_TRUE(outcome_.has_value());
  EXPECT_FALSE(exchange_.list_progress().has_value());
}

TEST_F(ParamList, OfALineThatFallsSilentEndsWithWhatCame) {
  list();
  const Time start = now_;
  for (std::uint16_t index = 0; index < 200; ++index) {
    answer("P" + std::to_string(index), index, 8000);
  }
  while (!outcome_ && now_ - start < 60s) pass(100ms);
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_LE(now_ - start, 12s);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
  EXPECT_EQ(outcome_->message, "the vehicle sent 200 of 8000 parameters, then no more");
  EXPECT_EQ(outcome_->parameters.size(), 200U) << "what came is not lost";
}

TEST_F(ParamList, IsDueWhenAnAnswerIsLate) {
  EXPECT_EQ(exchange_.due(), std::nullopt);
  list();
  EXPECT_EQ(exchange_.due(), now_ + 700ms);
  exchange_.read("P", now_ + 100ms, [](const Outcome&) {});
  EXPECT_EQ(exchange_.due(), now_ + 700ms);
  answer("P", 0, 1);
  EXPECT_EQ(exchange_.due(), std::nullopt);
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
  for (int i = 0; i < 100'000 && !outcome_; ++i) {
    answer("P" + std::to_string(i % 7), static_cast<std::uint16_t>(i % 3 == 0 ? 101 : 0),
           static_cast<std::uint16_t>(i % 2 == 0 ? 102 : 3));
    pass(100ms);
  }
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused) << outcome_->message;
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

TEST_F(ParamList, AParameterThatDoesNotAnswerMayBeOneThatIsKnown) {
  answer("MC_ROLL_P", 0, 1);
  exchange_.read("MC_ROL_P", now_, [this](const Outcome& outcome) { outcome_ = outcome; });
  for (int i = 0; i < 10 && !outcome_; ++i) pass(1s);
  ASSERT_TRUE(outcome_.has_value());
  EXPECT_NE(outcome_->message.find("; did you mean 'MC_ROLL_P'?"), std::string::npos)
      << outcome_->message;
}

TEST(ParamRoundTrip, GivesTheNumberBack) {
  struct RoundTripCase {
    const char* name;
    ParamEncoding encoding;
    MavParamType type;
    double value;
  };
  const RoundTripCase rows[] = {
      {"Px4Int32", ParamEncoding::kBytewise, MavParamType::kInt32, -2147483648.0},
      {"Px4Uint32", ParamEncoding::kBytewise, MavParamType::kUint32, 4294967295.0},
      {"Px4Int8", ParamEncoding::kBytewise, MavParamType::kInt8, -1},
      {"Px4Real", ParamEncoding::kBytewise, MavParamType::kReal32, 0.5},
      {"ArduPilotInt16", ParamEncoding::kCast, MavParamType::kInt16, -32768},
      {"ArduPilotInt32", ParamEncoding::kCast, MavParamType::kInt32, 65536}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    const auto wire = to_wire(test.encoding, test.type, test.value);
    ASSERT_TRUE(wire.has_value());
    EXPECT_EQ(from_wire(test.encoding, test.type, *wire), test.value);
  }
}

TEST(ParamValue, IntegersTravelAsTheirBytes) {
  EXPECT_EQ(std::bit_cast<std::uint32_t>(
                *to_wire(ParamEncoding::kBytewise, MavParamType::kInt32, 12345678)),
            12345678U);
}

TEST(ParamValue, RefusesWhatATypeCannotHold) {
  EXPECT_FALSE(to_wire(ParamEncoding::kBytewise, MavParamType::kInt8, 128));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kUint16, -1));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kInt32, 1.5));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kReal32, std::nan("")));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kReal32, 1e39));
}

TEST(ParamValue, PrintsTheShortestTextThatAFloatReadsBackFrom) {
  EXPECT_EQ(number_text(static_cast<double>(0.15F)), "0.15");
  EXPECT_EQ(number_text(3), "3");
  EXPECT_EQ(number_text(-2147483648.0), "-2147483648");
}

TEST(ParamValue, ComparesRealsAsFloats) {
  EXPECT_TRUE(same_value(MavParamType::kReal32, 0.15, static_cast<double>(0.15F)));
  EXPECT_FALSE(same_value(MavParamType::kReal32, 0.15, 0.1500001));
  EXPECT_FALSE(same_value(MavParamType::kInt32, 16777217, 16777216));
}

}  // namespace
}  // namespace cas::mav::services
