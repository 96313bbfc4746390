// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <csignal>

#include "tests/loopback/flight_bench.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

TEST(CasdCrash, AVehicleFliesOnWhenCasdIsKilledAndStartedAgain) {
  FlightBench bench("log: {tlog: $DIR/flight.tlog}\n");
  bench.start_vehicle();
  bench.start_casd();
  ASSERT_TRUE(bench.fly_to(5));

  for (int round = 1; round <= 3; ++round) {
    bench.casd().signal(SIGKILL);
    ASSERT_EQ(bench.casd().wait_exit(), 128 + SIGKILL);
    bench.start_casd();  // as systemd does

    // The link is back, and the vehicle is known again by what it says now.
    ASSERT_TRUE(wait_until([&] { return !bench.call("casd.status").at("vehicles").empty(); }));
    ASSERT_TRUE(wait_until([&] {
      const json state = bench.state();
      return state.contains("altitude_m") && state.contains("attitude");
    }));
    const json state = bench.state();
    EXPECT_EQ(state.at("armed"), true) << round;
    EXPECT_NEAR(state.at("altitude_m").get<double>(), 5, 1.5) << round;
    EXPECT_LT(state.at("attitude").at("age_s").get<double>(), 1.0) << "nothing stale";

    // No sensor message from before came late: each answer is to a sample of this casd's time.
    ASSERT_TRUE(wait_until([&] {
      const json echo = bench.call("link.echo");
      return !echo.empty() && echo[0].at("count").get<int>() > 400;
    }));
    EXPECT_LT(bench.call("link.echo")[0].at("p50").get<double>(), 50'000.0) << round;
    EXPECT_EQ(bench.call("link.list")[0].at("state"), "up");

    // Commands work, with no acknowledgement of before taken for theirs.
    EXPECT_TRUE(bench.command("vehicle.hold"));
    EXPECT_EQ(bench.call("param.get", {{"name", "MC_ROLLRATE_P"}}).at("type"), "REAL32");
    EXPECT_TRUE(
        std::filesystem::exists(bench.folder / ("flight." + std::to_string(round) + ".tlog")))
        << "the log of before was written over";
  }
  EXPECT_TRUE(bench.land());
}

}  // namespace
}  // namespace cas::test
