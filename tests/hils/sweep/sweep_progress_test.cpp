// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_progress.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace cas::hils {
namespace {

using std::chrono::seconds;

TEST(SweepProgress, TellsRateAndTimeLeftOfWhatThisProcessFlies) {
  EXPECT_EQ(sweep_line({.all = 1000, .done = 600, .flown = 100, .elapsed = seconds(25)}),
            "sweep: [############--------] 600 of 1000, 4.0 runs/s, 1:40 left");
  EXPECT_EQ(sweep_line({.all = 1000, .done = 1, .flown = 1, .unjudged = 1, .elapsed = seconds(2)}),
            "sweep: [--------------------] 1 of 1000, 0.5 runs/s, 1 without a verdict");
  EXPECT_EQ(sweep_line({.all = 2, .done = 2}), "sweep: [####################] 2 of 2");
}

}  // namespace
}  // namespace cas::hils
