// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <csignal>

#include "tests/loopback/flight_fixture.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

TEST(CasdCrash, AVehicleFliesOnWhenCasdIsKilledAndStartedAgain) {
  FlightFixture fixture("log: {tlog: $DIR/flight.tlog}\n");
  fixture.start_vehicle();
  fixture.start_casd();
  ASSERT_TRUE(fixture.fly_to(5));

  for (int round = 1; round <= 3; ++round) {
    fixture.casd().signal(SIGKILL);
    ASSERT_EQ(fixture.casd().wait_exit(), 128 + SIGKILL);
    fixture.start_casd();  // as systemd does

    // The link is back, and the vehicle is known again by what it says now.
    ASSERT_TRUE(wait_until([&] { return !fixture.call("casd.status").at("vehicles").empty(); }));
    ASSERT_TRUE(wait_until([&] {
      const json state = fixture.state();
      return state.contains("altitude_m") && state.contains("attitude");
    }));
    const json state = fixture.state();
    EXPECT_EQ(state.at("armed"), true) << round;
    EXPECT_NEAR(state.at("altitude_m").get<double>(), 5, 1.5) << round;
    EXPECT_LT(state.at("attitude").at("age_s").get<double>(), 1.0) << "nothing stale";

    // No sensor message from before came late: each answer is to a sample of this casd's time.
    ASSERT_TRUE(wait_until([&] {
      const json echo = fixture.call("link.echo");
      return !echo.empty() && echo[0].at("count").get<int>() > 400;
    }));
    EXPECT_LT(fixture.call("link.echo")[0].at("p50").get<double>(), 50'000.0) << round;
    EXPECT_EQ(fixture.call("link.list")[0].at("state"), "up");

    // Commands work, with no acknowledgement of before taken for theirs.
    EXPECT_TRUE(fixture.command("vehicle.hold"));
    EXPECT_EQ(fixture.call("param.get", {{"name", "MC_ROLLRATE_P"}}).at("type"), "REAL32");
    EXPECT_TRUE(
        std::filesystem::exists(fixture.folder / ("flight." + std::to_string(round) + ".tlog")))
        << "the log of before was written over";
  }
  EXPECT_TRUE(fixture.land());
}

}  // namespace
}  // namespace cas::test
