// SPDX-License-Identifier: BSD-3-Clause
// How fast lockstep is. For a quiet machine; scripts/bench_simulator prints the figure itself.
#include <gtest/gtest.h>

#include "tests/closed_loop/lockstep_fixture.hpp"

namespace cas::test {
namespace {

TEST(LockstepSpeed, IsSeveralTimesFasterThanRealTime) {
  LockstepFixture bench(1);
  const base::rpc::Json status = bench.run_until(20);
  EXPECT_GT(status["real_time_factor"], 5.0);
  EXPECT_EQ(status["lockstep_timeouts"], 0);
  EXPECT_TRUE(bench.stop()) << bench.outputs();
}

}  // namespace
}  // namespace cas::test
