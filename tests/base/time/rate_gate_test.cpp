// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/rate_gate.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cas::base {
namespace {

using namespace std::chrono_literals;

TEST(RateGateCount, IsExactOverAMinute) {
  struct RateCase {
    const char* name;
    double rate_hz;
    Duration step;
  };
  const RateCase rows[] = {
      {"ImuOn1kHz", 500, 1ms},       {"ControlOn500Hz", 400, 2ms}, {"ControlOn1kHz", 400, 1ms},
      {"Mag100On250Hz", 100, 4ms},   {"Baro50On1kHz", 50, 1ms},    {"GpsOn1kHz", 5, 1ms},
      {"HalfHertzOn1kHz", 0.5, 1ms}, {"SameAsGrid", 1000, 1ms},    {"ThirdOfAGrid", 333, 1ms}};
  for (const auto& [name, rate_hz, step] : rows) {
    SCOPED_TRACE(name);
    RateGate gate(rate_hz);
    int count = 0;
    for (Duration t = step; t <= 60s; t += step) count += gate.due(t) ? 1 : 0;
    EXPECT_EQ(count, static_cast<int>(60 * rate_hz));
  }
}

TEST(RateGate, ControlsOn500HzComeFourTwoTwoTwoMillisecondsApart) {
  RateGate gate(400);
  std::vector<int> due_ms;
  for (int t_ms = 2; t_ms <= 20; t_ms += 2) {
    if (gate.due(std::chrono::milliseconds(t_ms))) due_ms.push_back(t_ms);
  }
  EXPECT_EQ(due_ms, (std::vector<int>{4, 6, 8, 10, 14, 16, 18, 20}));
}

TEST(RateGate, ZeroMeansNever) {
  RateGate gate(0);
  EXPECT_FALSE(gate.due(1h));
}

TEST(RateGate, AGapOfSeveralPeriodsIsDueOnce) {
  RateGate gate(100);
  EXPECT_TRUE(gate.due(1s));
  EXPECT_FALSE(gate.due(1s));
  EXPECT_FALSE(gate.due(1s + 9ms));
  EXPECT_TRUE(gate.due(1s + 10ms));
}

TEST(RateGate, StaysExactAfterAMonth) {
  RateGate gate(400);
  EXPECT_EQ(gate.index_at(30 * 24h), 400LL * 30 * 24 * 3600);
}

TEST(RateGate, ResetReturnsToTimeZero) {
  RateGate gate(100);
  EXPECT_TRUE(gate.due(1s));
  gate.reset();
  EXPECT_TRUE(gate.due(10ms));
}

}  // namespace
}  // namespace cas::base
