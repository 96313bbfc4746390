// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/routing_rules.hpp"

#include <gtest/gtest.h>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

constexpr std::uint32_t kPrivate = 50'777;  // above the directly indexed ids

ForwardRule rule(LinkId from, LinkId to) {
  ForwardRule result;
  result.from = from;
  result.to = to;
  return result;
}

TEST(ForwardRules, WithoutARuleNothingPasses) {
  const ForwardRules rules;
  EXPECT_EQ(rules.from(0).destinations(0, {1, 1}), LinkMask{});
  EXPECT_EQ(rules.from(0).destinations(kPrivate, {1, 1}), LinkMask{});
}

TEST(ForwardRules, EmptyRuleLetsEverythingPassOneWay) {
  const ForwardRules rules(std::vector{rule(0, 1)});
  EXPECT_EQ(rules.from(0).destinations(0, {1, 1}), bit(1));
  EXPECT_EQ(rules.from(0).destinations(kPrivate, {1, 1}), bit(1));
  EXPECT_EQ(rules.from(1).destinations(0, {1, 1}), LinkMask{});
}

TEST(ForwardRules, AllowListLetsOnlyItsMessagesPass) {
  ForwardRule one = rule(0, 1);
  one.allow = std::vector<std::uint32_t>{107, kPrivate};
  const ForwardRules rules(std::vector{one});
  EXPECT_EQ(rules.from(0).destinations(107, {1, 1}), bit(1));
  EXPECT_EQ(rules.from(0).destinations(kPrivate, {1, 1}), bit(1));
  EXPECT_EQ(rules.from(0).destinations(0, {1, 1}), LinkMask{});
  EXPECT_EQ(rules.from(0).destinations(kPrivate + 1, {1, 1}), LinkMask{});
}

TEST(ForwardRules, EmptyAllowListLetsNothingPass) {
  ForwardRule one = rule(0, 1);
  one.allow.emplace();
  EXPECT_EQ(ForwardRules(std::vector{one}).from(0).destinations(0, {1, 1}), LinkMask{});
}

TEST(ForwardRules, BlockListHoldsItsMessagesBack) {
  ForwardRule one = rule(0, 1);
  one.block = {91, kPrivate};
  const ForwardRules rules(std::vector{one, rule(0, 2)});
  EXPECT_EQ(rules.from(0).destinations(91, {1, 1}), bit(2));
  EXPECT_EQ(rules.from(0).destinations(kPrivate, {1, 1}), bit(2));
  EXPECT_EQ(rules.from(0).destinations(0, {1, 1}), bit(1) | bit(2));
}

TEST(ForwardRules, RuleOfALaterLinkCoversIdsThatAnEarlierOneNamed) {
  ForwardRule one = rule(0, 1);
  one.block = {kPrivate};
  EXPECT_EQ(ForwardRules(std::vector{one, rule(0, 2)}).from(0).destinations(kPrivate, {1, 1}),
            bit(2));
  EXPECT_EQ(ForwardRules(std::vector{rule(0, 2), one}).from(0).destinations(kPrivate, {1, 1}),
            bit(2));
}

TEST(ForwardRules, SystemsAndComponentsOfTheSenderAreFilters) {
  ForwardRule one = rule(0, 1);
  one.allow_systems = {1, 2};
  one.block_components = {100};
  const ForwardRules rules(std::vector{one});
  EXPECT_EQ(rules.from(0).destinations(0, {1, 1}), bit(1));
  EXPECT_EQ(rules.from(0).destinations(0, {3, 1}), LinkMask{});
  EXPECT_EQ(rules.from(0).destinations(0, {2, 100}), LinkMask{});
}

RateRule max_hz(std::uint32_t id, double hz) { return {.message_id = id, .max_hz = hz}; }
RateRule every(std::uint32_t id, unsigned n) { return {.message_id = id, .every = n}; }

int passed(const RateRule& rate, int packets, base::Duration period) {
  const std::vector<RateLimit> limits{{1, rate, 0}};
  RateLimiter limiter(1);
  int count = 0;
  for (int i = 0; i < packets; ++i) {
    count += limiter.admit(limits, rate.message_id, {1, 1}, bit(1), at(i * period)).empty() ? 0 : 1;
  }
  return count;
}

TEST(RateLimiter, ThinsOutToARate) {
  EXPECT_EQ(passed(max_hz(30, 50), 500, milliseconds(2)), 50);
  EXPECT_EQ(passed(max_hz(30, 30), 500, milliseconds(2)), 30);
  EXPECT_EQ(passed(max_hz(30, 1000), 500, milliseconds(2)), 500);
}

TEST(RateLimiter, LetsEachNthPass) {
  EXPECT_EQ(passed(every(30, 4), 100, milliseconds(1)), 25);
  EXPECT_EQ(passed(every(30, 1), 100, milliseconds(1)), 100);
}

TEST(RateLimiter, PauseIsNotRepaidAsABurst) {
  const std::vector<RateLimit> limits{{1, max_hz(30, 10), 0}};
  RateLimiter limiter(1);
  EXPECT_NE(limiter.admit(limits, 30, {1, 1}, bit(1), at({})), LinkMask{});
  const base::Duration later = std::chrono::seconds(10);
  EXPECT_NE(limiter.admit(limits, 30, {1, 1}, bit(1), at(later)), LinkMask{});
  EXPECT_EQ(limiter.admit(limits, 30, {1, 1}, bit(1), at(later + milliseconds(1))), LinkMask{});
}

TEST(RateLimiter, CountsEachSenderByItself) {
  const std::vector<RateLimit> limits{{1, every(30, 2), 0}};
  RateLimiter limiter(1);
  EXPECT_NE(limiter.admit(limits, 30, {1, 1}, bit(1), at({})), LinkMask{});
  EXPECT_NE(limiter.admit(limits, 30, {2, 1}, bit(1), at({})), LinkMask{});
  EXPECT_EQ(limiter.admit(limits, 30, {1, 1}, bit(1), at({})), LinkMask{});
}

TEST(RateLimiter, LeavesOtherLinksAndMessagesAlone) {
  const std::vector<RateLimit> limits{{1, every(30, 100), 0}};
  RateLimiter limiter(1);
  const LinkMask both = bit(1) | bit(2);
  EXPECT_EQ(limiter.admit(limits, 30, {1, 1}, both, at({})), both);
  EXPECT_EQ(limiter.admit(limits, 30, {1, 1}, both, at({})), bit(2));
  EXPECT_EQ(limiter.admit(limits, 31, {1, 1}, both, at({})), both);
}

}  // namespace
}  // namespace cas::casd::test
