// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/pid.hpp"

#include <gtest/gtest.h>

namespace cas::fcu {
namespace {

constexpr double kDt = 0.01;

TEST(Pid, SumsItsThreeParts) {
  Pid pid;
  pid.set_gains({2, 3, 0.5});
  EXPECT_DOUBLE_EQ(pid.update(1.0, 4.0, kDt), 2 * 1.0 + 3 * 1.0 * kDt - 0.5 * 4.0);
}

TEST(Pid, TakesTheDerivativeOfTheMeasurementSoThatAStepGivesNoKick) {
  Pid pid;
  pid.set_gains({0, 0, 10});
  pid.update(0, 0, kDt);
  EXPECT_DOUBLE_EQ(pid.update(100, 0, kDt), 0);
}

TEST(Pid, StopsIntegratingInTheDirectionOfSaturationOnly) {
  Pid pid;
  pid.set_gains({0, 1, 0});
  for (int i = 0; i < 100; ++i) pid.update(1, 0, kDt, {.up = true});
  EXPECT_DOUBLE_EQ(pid.integral(), 0);
  for (int i = 0; i < 100; ++i) pid.update(-1, 0, kDt, {.up = true});
  EXPECT_NEAR(pid.integral(), -1, 1e-12);
}

TEST(Pid, KeepsItsIntegralWithinTheLimit) {
  Pid pid;
  pid.set_gains({0, 10, 0, 0.3});
  for (int i = 0; i < 1000; ++i) pid.update(1, 0, kDt);
  EXPECT_DOUBLE_EQ(pid.integral(), 0.3);
}

TEST(Pid, ChangesGainsWithoutABump) {
  Pid pid;
  pid.set_gains({2, 1, 0.1});
  double before = 0;
  for (int i = 0; i < 50; ++i) before = pid.update(0.4, 0.2, kDt);
  pid.set_gains({5, 1, 0.3});
  const double step_of_the_integrator = 1 * 0.4 * kDt;
  EXPECT_NEAR(pid.update(0.4, 0.2, kDt), before + step_of_the_integrator, 1e-12);
}

TEST(Pid, KeepsNoOffsetWhenThereIsNoIntegratorToTakeItAway) {
  Pid pid;
  pid.set_gains({2, 0, 0});
  pid.update(1, 0, kDt);
  pid.set_gains({3, 0, 0});
  EXPECT_DOUBLE_EQ(pid.update(1, 0, kDt), 3);
}

}  // namespace
}  // namespace cas::fcu
