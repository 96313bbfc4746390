// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/address_choice.hpp"

#include <gtest/gtest.h>

namespace cas::casd::test {
namespace {

using Step = AddressChoice::Step;

constexpr AddressChoice::Second kHeard{.heard = true, .sent = true};
constexpr AddressChoice::Second kSent{.sent = true};
constexpr AddressChoice::Second kRefused{.sent = true, .refused = true};
constexpr AddressChoice::Second kNothing{};

TEST(AddressChoice, ARefusalTakesTheNextAddressWithinASecond) {
  AddressChoice choice(2);
  EXPECT_EQ(choice.on_second(kRefused), Step::kNext);
  EXPECT_EQ(choice.current(), 1U);
}

TEST(AddressChoice, OfAddressesThatAllRefuseTheNameIsLookedUpAgain) {
  AddressChoice choice(2);
  choice.on_second(kRefused);
  EXPECT_EQ(choice.on_second(kRefused), Step::kLookUp);
}

TEST(AddressChoice, TheOnlyAddressIsLookedUpAgainAfterSecondsOfRefusal) {
  AddressChoice choice(1);
  for (int i = 1; i < AddressChoice::kRefusals_s; ++i) {
    EXPECT_EQ(choice.on_second(kRefused), Step::kStay);
  }
  EXPECT_EQ(choice.on_second(kRefused), Step::kLookUp);
}

TEST(AddressChoice, RefusalsCountWithoutAPauseOnly) {
  AddressChoice choice(1);
  for (int i = 1; i < AddressChoice::kCompare_s; ++i) {
    EXPECT_EQ(choice.on_second(kRefused), Step::kStay);
    EXPECT_EQ(choice.on_second(kSent), Step::kStay);
  }
}

TEST(AddressChoice, WhoAnsweredIsKeptThroughSilenceUnlessTheNameLeadsElsewhere) {
  AddressChoice choice(2);
  choice.on_second(kHeard);
  for (int i = 1; i < 100; ++i) {
    const bool compares = i % AddressChoice::kCompare_s == 0;
    EXPECT_EQ(choice.on_second(kSent), compares ? Step::kCompare : Step::kStay) << i;
  }
  EXPECT_EQ(choice.current(), 0U);
}

TEST(AddressChoice, ASilentAddressGivesWayOnceAndIsTakenAgain) {
  AddressChoice choice(2);
  int moves = 0;
  for (int i = 0; i < 100; ++i) moves += choice.on_second(kSent) == Step::kNext ? 1 : 0;
  EXPECT_EQ(moves, 2);
  EXPECT_EQ(choice.current(), 0U);
}

TEST(AddressChoice, NothingIsDecidedWhileNothingIsSent) {
  AddressChoice choice(2);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(choice.on_second(kNothing), Step::kStay);
}

TEST(AddressChoice, AnAddressWithoutASocketIsLeftOut) {
  AddressChoice choice(3);
  EXPECT_TRUE(choice.leave());
  EXPECT_TRUE(choice.leave());
  EXPECT_EQ(choice.current(), 2U);
  EXPECT_FALSE(choice.leave());
}

}  // namespace
}  // namespace cas::casd::test
