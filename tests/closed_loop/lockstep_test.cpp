// SPDX-License-Identifier: BSD-3-Clause
// The three programs in lockstep over UDP and a pseudo-terminal: the same seed, the same bytes.
#include <gtest/gtest.h>

#include "tests/closed_loop/lockstep_fixture.hpp"
#include "tests/support/battery_vehicle.hpp"

namespace cas::test {
namespace {

constexpr int kSimulator = 256 * 1 + 200;
constexpr int kController = 256 * 1 + 1;
constexpr int kCasd = 256 * 254 + 190;

/// Asks each half second until the vehicle knows where it is. @return when it armed, s
double arm(LockstepFixture& bench) {
  for (double time_s = 6; time_s < 60; time_s += 0.5) {
    bench.run_until(time_s);
    try {
      bench.command("vehicle.arm", base::rpc::Json::object());
      return time_s;
    } catch (const base::rpc::CallError&) {
      continue;  // not yet
    }
  }
  ADD_FAILURE() << "it never armed";
  return 60;
}

/// Results of a take-off.
struct Flight {
  std::string truth;
  std::string recording;
  std::map<int, std::string> streams;
  base::rpc::Json status;
};

Flight take_off(std::uint64_t seed, const std::string& vehicle = "iris_paper") {
  LockstepFixture bench(seed, vehicle);
  bench.run_until(0.01);
  EXPECT_TRUE(bench.wait_heard()) << bench.outputs();
  const double armed_s = arm(bench);
  bench.run_until(armed_s + 0.5);
  bench.command("vehicle.takeoff", {{"altitude_m", 2}});
  Flight run;
  run.status = bench.run_until(armed_s + 4);
  EXPECT_TRUE(bench.stop()) << bench.outputs();
  run.truth = bench.truth();
  run.recording = bench.recording();
  run.streams = bench.streams();
  return run;
}

double height(const Flight& run) { return run.status["vehicles"][0]["p_W"][2].get<double>(); }

TEST(Lockstep, SameSeedGivesTheSameBytesThroughRealProcesses) {
  const Flight first = take_off(1);
  const Flight again = take_off(1);
  EXPECT_GT(height(first), 0.5) << "it flies";
  EXPECT_EQ(first.status["lockstep_timeouts"], 0);
  EXPECT_TRUE(first.truth == again.truth);
  for (const int source : {kSimulator, kController, kCasd}) {
    ASSERT_TRUE(first.streams.contains(source)) << source;
    EXPECT_TRUE(first.streams.at(source) == again.streams.at(source)) << source;
  }
  EXPECT_TRUE(first.recording == again.recording) << "their order or times differ";
}

TEST(Lockstep, AHexarotorsSixthOutputReachesItsRotor) {
  const Flight run = take_off(1, "hexa_x");
  EXPECT_GT(height(run), 0.5) << "it flies";
  const std::string header = run.truth.substr(0, run.truth.find('\n'));
  EXPECT_TRUE(header.ends_with(",omega6_rad_s")) << header;
  const std::string rest = run.truth.substr(0, run.truth.find_last_not_of('\n') + 1);
  const double omega_6 = std::stod(rest.substr(rest.rfind(',') + 1));
  constexpr double kIdle_rad_s = 100;
  EXPECT_GT(omega_6, 3 * kIdle_rad_s) << "of 551 in hover";
}

/// Hover takes some 47 A of it: empty after half a minute.
TEST(Lockstep, ABatteryThatEmptiesInTheSimulatorBringsTheControllersFailsafe) {
  const TemporaryFolder folder;
  LockstepFixture bench(1, write_with_battery(folder,
                                              "{full_v: 16, empty_v: 15, capacity_ah: 0.4, "
                                              "resistance_ohm: 0.005, efficiency: 1}"));
  bench.run_until(0.01);
  ASSERT_TRUE(bench.wait_heard()) << bench.outputs();
  const auto battery = [&] {
    return bench.command("vehicle.telemetry", base::rpc::Json::object()).at("battery");
  };
  const auto state = [&] { return bench.command("vehicle.state", base::rpc::Json::object()); };

  const double armed_s = arm(bench);
  const auto full = battery();
  EXPECT_NEAR(full.at("voltage_v").get<double>(), 16, 0.05) << full;
  EXPECT_EQ(full.at("remaining_percent"), 100) << full;
  bench.run_until(armed_s + 0.5);
  bench.command("vehicle.takeoff", {{"altitude_m", 2}});
  bench.run_until(armed_s + 6);
  const auto used = battery();
  EXPECT_LT(used.at("voltage_v").get<double>(), 15.8) << used;
  EXPECT_GT(used.at("current_a").get<double>(), 30) << used;
  EXPECT_LT(used.at("remaining_percent").get<double>(), 90) << used;
  EXPECT_NE(state().at("mode"), "LAND") << state();

  double left = 100;
  for (double time_s = armed_s + 6.5; left >= 4 && time_s < armed_s + 40; time_s += 0.5) {
    bench.run_until(time_s);
    left = battery().at("remaining_percent").get<double>();
  }
  EXPECT_LT(left, 4);
  const auto end = state();
  EXPECT_EQ(end.at("mode"), "LAND") << end;
  EXPECT_NE(end.dump().find("Low battery"), std::string::npos) << end;
  EXPECT_NE(end.dump().find("Battery failsafe: landing"), std::string::npos) << end;
  EXPECT_TRUE(bench.stop()) << bench.outputs();
}

std::string sensors_at_rest(std::uint64_t seed) {
  LockstepFixture bench(seed);
  bench.run_until(0.5);
  EXPECT_TRUE(bench.stop()) << bench.outputs();
  return bench.streams()[kSimulator];
}

TEST(Lockstep, AnotherSeedHasOtherSensors) {
  const std::string first = sensors_at_rest(1);
  EXPECT_GT(first.size(), 10'000U);
  EXPECT_FALSE(first == sensors_at_rest(2));
}

}  // namespace
}  // namespace cas::test
