// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/fcu_device.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

using Direction = base::LedgerEntry::Direction;

constexpr std::uint32_t kSensor = 107;
constexpr std::uint32_t kControls = 91;

/// Two sensors and two controls, the latter by a clock that is `ahead_us` ahead.
RunRecord record_with(std::uint64_t ahead_us) {
  RunRecord record;
  for (const std::uint64_t stamp : {4'000'000U, 4'002'000U}) {
    const auto at_ns = static_cast<std::int64_t>(1000 * stamp);
    record.simulator.push_back({Direction::kSent, kSensor, stamp, at_ns});
    record.controller.push_back({Direction::kReceived, kSensor, stamp, at_ns});
    record.controller.push_back({Direction::kSent, kControls, stamp + ahead_us, at_ns + 1000});
    record.simulator.push_back({Direction::kReceived, kControls, stamp + ahead_us, at_ns + 2000});
  }
  return record;
}

TEST(ControlStamps, OfAnotherClockAreMovedToSimulatedTimeAtBothEnds) {
  RunRecord record = record_with(77'000'000);
  align_control_stamps(record);
  EXPECT_TRUE(record.foreign_stamps);
  EXPECT_EQ(record.controller[1].time_usec, 4'000'000U);
  EXPECT_EQ(record.controller[3].time_usec, 4'002'000U);
  EXPECT_EQ(record.simulator[1].time_usec, 4'000'000U);
  EXPECT_EQ(record.simulator[3].time_usec, 4'002'000U);
}

TEST(ControlStamps, ThatEchoTheSensorsStay) {
  RunRecord record = record_with(0);
  align_control_stamps(record);
  EXPECT_FALSE(record.foreign_stamps);
  EXPECT_EQ(record.controller[1].time_usec, 4'000'000U);
}

}  // namespace
}  // namespace cas::hils
