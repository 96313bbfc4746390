// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/pace_watch.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace cas::sim {
namespace {

using std::chrono::milliseconds;

LoopFigures at(int simulated_ms, double wall_s, std::uint64_t late) {
  LoopFigures figures;
  figures.time = base::SimTime(milliseconds(simulated_ms));
  figures.steps = static_cast<std::uint64_t>(simulated_ms);
  figures.wall_s = wall_s;
  figures.late_steps = late;
  return figures;
}

TEST(PaceWatch, IsSilentWhileTheLoopKeepsUp) {
  PaceWatch watch(1.0);
  EXPECT_FALSE(watch.look(at(5000, 5.0, 10)));
  EXPECT_FALSE(watch.look(at(10'000, 10.0, 60)));
}

TEST(PaceWatch, TellsOfSlownessAndOfLateSteps) {
  PaceWatch watch(1.0);
  EXPECT_FALSE(watch.look(at(5000, 5.0, 0)));
  EXPECT_EQ(watch.look(at(9850, 10.0, 20)),
            "falls behind: 0.97 x real time, 20 of 4850 steps late in the last 5 s");
  EXPECT_EQ(watch.look(at(14'850, 15.0, 320)),
            "steps begin late: 1.00 x real time, 300 of 5000 steps late in the last 5 s");
  EXPECT_FALSE(watch.look(at(19'850, 20.0, 330))) << "only what came since the last look counts";
}

TEST(PaceWatch, HoldsTheLoopToTheOrderedSpeed) {
  PaceWatch watch(2.0);
  EXPECT_TRUE(watch.look(at(5000, 5.0, 0)));
  EXPECT_FALSE(watch.look(at(15'000, 10.0, 0)));
}

TEST(PaceWatch, ComparesNothingAfterAPauseOrAReset) {
  PaceWatch watch(1.0);
  watch.look(at(5000, 5.0, 0));
  LoopFigures paused = at(5000, 5.0, 0);
  paused.paused = true;
  EXPECT_FALSE(watch.look(paused));
  EXPECT_FALSE(watch.look(at(100, 0.2, 50))) << "a reset";
}

}  // namespace
}  // namespace cas::sim
