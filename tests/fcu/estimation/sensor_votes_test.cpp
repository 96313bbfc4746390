// SPDX-License-Identifier: BSD-3-Clause
// Which of several IMUs and receivers is flown by.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <optional>

#include "base/angles.hpp"
#include "base/random.hpp"
#include "fcu/estimation/gps_vote.hpp"
#include "fcu/estimation/imu_vote.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector3d;

constexpr int kRateHz = 500;
constexpr int kFaultAt = 1000;  // sample, 2 s

base::SimTime at(int sample) { return base::SimTime(std::chrono::microseconds(2000 * sample)); }

/// Changes the sample of the first IMU. @return whether there is one
using Break = std::function<bool(ImuInput&)>;

struct Outcome {
  std::optional<VoteSwitch> change;
  double after_s = 0;  ///< the fault
  int used = 0;
};

/// Feeds `imus` IMUs with noise for 4 s; the first breaks after 2 s.
Outcome vote(int imus, const Break& breaks) {
  ImuVote vote;
  base::NormalRandom random(7);
  Outcome outcome;
  for (int i = 1; i < 2 * kFaultAt; ++i) {
    for (int imu = 0; imu < imus; ++imu) {
      ImuInput input{at(i), Vector3d(0.02, 0, 0), Vector3d(0, 0, -9.8)};
      for (int axis = 0; axis < 3; ++axis) {
        input.gyro_D[axis] += 0.01 * random();
        input.accel_D[axis] += 0.1 * random();
      }
      const bool speaks = imu > 0 || i < kFaultAt || breaks(input);
      if (speaks) vote.on_sample(imu, input);
    }
    vote.choose(at(i));
    if (const auto change = vote.take_switch()) {
      EXPECT_FALSE(outcome.change) << "changed twice";
      outcome.change = change;
      outcome.after_s = static_cast<double>(i - kFaultAt) / kRateHz;
    }
  }
  outcome.used = vote.used();
  return outcome;
}

bool stuck(ImuInput& imu) {
  imu.gyro_D = Vector3d(0.1, 0.2, 0.3);
  imu.accel_D = Vector3d(0, 0, -9);
  return true;
}

TEST(BrokenImu, IsLeftWithinASecond) {
  struct BreakCase {
    const char* name;
    Break breaks;
    VoteCause cause;
  };
  const BreakCase rows[] = {{"Silent", [](ImuInput&) { return false; }, VoteCause::kSilent},
                            {"GyroOff",
                             [](ImuInput& imu) {
                               imu.gyro_D.x() += 10 * base::kRadPerDeg;
                               return true;
                             },
                             VoteCause::kDisagrees},
                            {"AccelOff",
                             [](ImuInput& imu) {
                               imu.accel_D.x() += 2;
                               return true;
                             },
                             VoteCause::kDisagrees},
                            {"NoNumbers",
                             [](ImuInput& imu) {
                               imu.gyro_D.x() = std::numeric_limits<double>::quiet_NaN();
                               return true;
                             },
                             VoteCause::kDisagrees},
                            {"GyroStuck",
                             [](ImuInput& imu) {
                               imu.gyro_D = Vector3d(0.02, 0, 0);
                               return true;
                             },
                             VoteCause::kStuck}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const Outcome outcome = vote(3, row.breaks);
    ASSERT_TRUE(outcome.change);
    EXPECT_EQ(outcome.change->from, 0);
    EXPECT_EQ(outcome.change->to, 1);
    EXPECT_EQ(outcome.change->cause, row.cause);
    EXPECT_GE(outcome.after_s, 0);
    EXPECT_LT(outcome.after_s, 1);
    EXPECT_EQ(outcome.used, 1);
  }
}

TEST(ImuVote, KeepsTheFirstWhileNothingIsWrong) {
  EXPECT_FALSE(vote(3, [](ImuInput&) { return true; }).change);
  EXPECT_FALSE(vote(2, [](ImuInput&) { return true; }).change);
}

TEST(ImuVote, OfTwoLeavesTheStuckOneAndKeepsTheOneThatDisagrees) {
  EXPECT_TRUE(vote(2, stuck).change);
  EXPECT_FALSE(vote(2, [](ImuInput& imu) {
                 imu.gyro_D.x() += 1;
                 return true;
               }).change);
}

TEST(ImuVote, KeepsTheLastOneWhateverItDoes) {
  EXPECT_FALSE(vote(1, stuck).change);
  EXPECT_EQ(vote(1, stuck).used, 0);
}

/// Feeds two receivers at 5 Hz for 4 s. @param off  of the first after 2 s, in limits; nullopt: it
/// is silent
Outcome receivers(std::optional<double> off, double off_of_other) {
  GpsVote vote;
  Outcome outcome;
  for (int i = 1; i < 20; ++i) {
    const auto now = base::SimTime(std::chrono::milliseconds(200 * i));
    for (int receiver = 0; receiver < 2; ++receiver) {
      const bool broken = receiver == 0 && i >= 10;
      if (broken && !off) continue;
      GpsVote::Fix fix{.heard = now, .has_fix = true, .digits = {}, .off = off_of_other};
      if (receiver == 0) fix.off = broken ? *off : 0.1;
      fix.digits.time_usec = static_cast<std::uint64_t>(i);
      fix.digits.digits[0] = i;
      vote.on_fix(receiver, fix);
      if (const auto change = vote.take_switch()) {
        outcome.change = change;
        outcome.after_s = 0.2 * (i - 10);
      }
    }
  }
  outcome.used = vote.used();
  return outcome;
}

TEST(GpsVote, LeavesTheReceiverThatJumpsWithinASecond) {
  const Outcome outcome = receivers(6, 0.3);
  ASSERT_TRUE(outcome.change);
  EXPECT_EQ(outcome.change->cause, VoteCause::kDisagrees);
  EXPECT_LT(outcome.after_s, 1);
  EXPECT_EQ(outcome.used, 1);
}

TEST(GpsVote, LeavesTheSilentReceiverWithinASecond) {
  const Outcome outcome = receivers(std::nullopt, 0.3);
  ASSERT_TRUE(outcome.change);
  EXPECT_EQ(outcome.change->cause, VoteCause::kSilent);
  EXPECT_LT(outcome.after_s, 1);
}

TEST(GpsVote, KeepsTheReceiverWhenBothAreFarBecauseTheEstimateIs) {
  EXPECT_FALSE(receivers(6, 5.5).change);
}

}  // namespace
}  // namespace cas::fcu
