// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/standstill.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace cas::casd {
namespace {

using std::chrono::milliseconds;

constexpr base::Duration kPatience = milliseconds(25);

base::RunTime at(base::Duration time) { return base::RunTime(std::chrono::hours(1)) + time; }

TEST(Standstill, LastsFromTheFirstThatWasGivenUntilItIsTaken) {
  Standstill line(kPatience);
  EXPECT_FALSE(line.pending());
  line.given(at({}));
  line.given(at(milliseconds(10)));
  EXPECT_TRUE(line.pending());
  EXPECT_EQ(line.lasts(at(milliseconds(30))), milliseconds(30));
  EXPECT_FALSE(line.ended(at(milliseconds(30)))) << "its driver was not emptied";
  EXPECT_FALSE(line.pending());
}

TEST(Standstill, EmptiesTheDriverOnceInEachStandstill) {
  Standstill line(kPatience);
  for (int i = 0; i < 2; ++i) {
    line.given(at({}));
    EXPECT_FALSE(line.flush_is_due(at(milliseconds(1000))));
    EXPECT_TRUE(line.flush_is_due(at(milliseconds(1001))));
    EXPECT_FALSE(line.flush_is_due(at(milliseconds(5000))));
    EXPECT_TRUE(line.ended(at(milliseconds(5000))));
  }
  Standstill patient(milliseconds(3000));
  patient.given(at({}));
  EXPECT_FALSE(patient.flush_is_due(at(milliseconds(2999))));
}

TEST(Standstill, NudgesAfterEverLongerTimes) {
  Standstill line(kPatience);
  line.given(at({}));
  EXPECT_FALSE(line.nudge_is_due(at(milliseconds(50))));
  EXPECT_TRUE(line.nudge_is_due(at(milliseconds(60))));
  EXPECT_FALSE(line.nudge_is_due(at(milliseconds(120))));
  EXPECT_TRUE(line.nudge_is_due(at(milliseconds(121))));
  line.ended(at(milliseconds(130)));
  line.given(at(milliseconds(200)));
  EXPECT_TRUE(line.nudge_is_due(at(milliseconds(251)))) << "as at first";
}

TEST(Standstill, IsLeftInPeaceForHalfOfThePatienceAndCountsFromTheNextLook) {
  Standstill line(kPatience);
  line.given(at({}));
  EXPECT_FALSE(line.look_begins(at({}))) << "a fresh line is looked at";
  line.ended(at(milliseconds(2)));
  line.given(at(milliseconds(2)));
  EXPECT_TRUE(line.rests(at(milliseconds(14))));
  EXPECT_FALSE(line.rests(at(milliseconds(15))));
  EXPECT_TRUE(line.look_begins(at(milliseconds(15))));
  EXPECT_FALSE(line.look_begins(at(milliseconds(16)))) << "it has begun";
  EXPECT_EQ(line.lasts(at(milliseconds(17))), milliseconds(2));
}

TEST(Standstill, IsLookedAtLessOftenTheLongerItLasts) {
  Standstill line(kPatience);
  line.given(at({}));
  EXPECT_EQ(line.next_look(at(milliseconds(8))), at(milliseconds(9)));
  EXPECT_EQ(line.next_look(at(milliseconds(320))), at(milliseconds(340)));
  EXPECT_EQ(line.next_look(at(milliseconds(8000))), at(milliseconds(8050)));
}

}  // namespace
}  // namespace cas::casd
