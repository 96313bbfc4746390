// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/loop_guard.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using Verdict = LoopGuard::Verdict;

constexpr LinkId kVehicle = 0;
constexpr LinkId kBack = 1;
constexpr int kProof = 1 + static_cast<int>(LoopGuard::kEnough);

class LoopGuardTest : public testing::Test {
 protected:
  Verdict comes(LinkId from, unsigned n, base::Duration when) {
    mavlink::common::HilSensor sensor{.time_usec = n};
    const auto sent = packet(sensor, {1, 1}, static_cast<std::uint8_t>(n));
    return guard_->on_packet(from, view(sent), at(when));
  }
  /// How often a packet goes round before it is dropped.
  int turns(unsigned n, base::Duration begin, base::Duration turn) {
    comes(kVehicle, n, begin);
    int count = 0;
    while (count < 1000 && comes(kBack, n, begin + ++count * turn) == Verdict::kFine) continue;
    return count;
  }

  std::optional<LoopGuard> guard_{std::in_place};
};

TEST_F(LoopGuardTest, APacketThatGoesRoundIsDroppedAfterSomeTurnsHoweverFastOrSlow) {
  for (const base::Duration turn :
       {base::Duration(1), base::Duration(microseconds(50)), base::Duration(milliseconds(2)),
        base::Duration(milliseconds(20)), base::Duration(milliseconds(300))}) {
    guard_.emplace();
    EXPECT_EQ(turns(7, {}, turn), kProof) << turn.count();
  }
}

TEST_F(LoopGuardTest, FurtherPacketsAreDroppedWhenTheyFirstComeBack) {
  turns(7, {}, milliseconds(2));
  for (unsigned n = 8; n < 500; ++n) EXPECT_EQ(turns(n, milliseconds(20 * n), milliseconds(2)), 1);
}

TEST_F(LoopGuardTest, OthersOfThatLinkPassDuringALoop) {
  turns(7, {}, milliseconds(2));
  EXPECT_EQ(comes(kBack, 100, milliseconds(50)), Verdict::kFine);
}

TEST_F(LoopGuardTest, ALinkIsTrustedAgainAfterACalm) {
  turns(7, {}, milliseconds(2));
  const base::Duration later = 2 * LoopGuard::kCalm;
  EXPECT_EQ(comes(kBack, 100, later), Verdict::kFine);
  EXPECT_EQ(turns(8, later, milliseconds(2)), kProof);
}

TEST_F(LoopGuardTest, ASenderMayRepeatItself) {
  for (unsigned i = 0; i < 1000; ++i) {
    EXPECT_EQ(comes(kVehicle, 7, milliseconds(i)), Verdict::kFine);
  }
}

TEST_F(LoopGuardTest, TwoWaysToOneVehicleAreNoLoop) {
  for (unsigned i = 0; i < 5000; ++i) {
    EXPECT_EQ(comes(kVehicle, i, milliseconds(10 * i)), Verdict::kFine);
    EXPECT_EQ(comes(kBack, i, milliseconds(10 * i + 1)), Verdict::kFine);
  }
}

TEST_F(LoopGuardTest, NorIsARecordingThatIsPlayedOverBothAgainAndAgain) {
  unsigned step = 0;
  for (int round = 0; round < 20; ++round) {
    for (const LinkId link : {kVehicle, kVehicle, kBack, kBack, kBack}) {
      for (unsigned n = 0; n < 40; ++n) {
        EXPECT_EQ(comes(link, n, milliseconds(2 * ++step)), Verdict::kFine);
      }
    }
  }
}

TEST_F(LoopGuardTest, NorAreTheyWhenTheVehicleRepeatsItself) {
  for (const int apart_ms : {0, 3}) {
    guard_.emplace();
    for (unsigned i = 0; i < 1000; ++i) {
      EXPECT_EQ(comes(kVehicle, 7, milliseconds(10 * i)), Verdict::kFine);
      EXPECT_EQ(comes(kBack, 7, milliseconds(10 * i + apart_ms)), Verdict::kFine);
    }
  }
}

TEST_F(LoopGuardTest, NorIsTheSecondLinkOfAVehicleThatRepeatsItselfWhenTheFirstOneDies) {
  for (const int period_ms : {5, 50, 100, 390}) {
    guard_.emplace();
    for (int i = 0; i < 100; ++i) {
      const base::Duration when = milliseconds(period_ms * i);
      if (i < 20) {
        EXPECT_EQ(comes(kVehicle, 7, when), Verdict::kFine);
      }
      EXPECT_EQ(comes(kBack, 7, when + milliseconds(3)), Verdict::kFine) << period_ms << " " << i;
    }
  }
}

TEST_F(LoopGuardTest, NorIsOneThatTakesOver) {
  for (int i = 0; i < 20; ++i) comes(kVehicle, 7, milliseconds(100 * i));
  for (int i = 20; i < 100; ++i) {
    EXPECT_EQ(comes(kBack, 7, milliseconds(100 * i + 5 * (i % 3))), Verdict::kFine);
  }
}

TEST_F(LoopGuardTest, NorIsTheBetterOneWhileTheOtherComesAndGoes) {
  for (int i = 0; i < 300; ++i) {
    if (i % 50 == 10) comes(kVehicle, 7, milliseconds(100 * i));
    EXPECT_EQ(comes(kBack, 7, milliseconds(100 * i + 3)), Verdict::kFine) << i;
  }
}

TEST_F(LoopGuardTest, NorIsALinkOverWhichTheSameIsRepeatedFaster) {
  for (int i = 0; i < 40; ++i) comes(kVehicle, 7, milliseconds(5 * i));
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(comes(kBack, 7, milliseconds(600 + i)), Verdict::kFine) << i;
  }
}

}  // namespace
}  // namespace cas::casd::test
