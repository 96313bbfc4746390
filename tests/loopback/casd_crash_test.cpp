// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <string>

#include "tests/loopback/flight_fixture.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

int logs_in(const std::filesystem::path& folder) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".tlog") ++count;
  }
  return count;
}

/// The vehicle that was in the air is there again, flies, and obeys commands.
void expect_flying(FlightFixture& fixture, const std::string& after) {
  // The link is back, and the vehicle is known again by new messages.
  ASSERT_TRUE(wait_until([&] { return !fixture.call("casd.status").at("vehicles").empty(); }));
  ASSERT_TRUE(wait_until([&] {
    const json state = fixture.state();
    return state.contains("altitude_m") && state.contains("attitude");
  }));
  const json state = fixture.state();
  EXPECT_EQ(state.at("armed"), true) << after;
  EXPECT_NEAR(state.at("altitude_m").get<double>(), 5, 1.5) << after;
  EXPECT_LT(state.at("attitude").at("age_s").get<double>(), 1.0) << "nothing stale";

  // No sensor message from before came late: each answer is to a sample of this casd's time.
  ASSERT_TRUE(wait_until([&] {
    const json echo = fixture.call("link.echo");
    return !echo.empty() && echo[0].at("count").get<int>() > 400;
  }));
  EXPECT_LT(fixture.call("link.echo")[0].at("p50").get<double>(), 50'000.0) << after;
  EXPECT_EQ(fixture.call("link.list")[0].at("state"), "up");

  // Commands work, and no earlier acknowledgement is taken for theirs.
  EXPECT_TRUE(fixture.command("vehicle.hold"));
  EXPECT_EQ(fixture.call("param.get", {{"name", "MC_ROLLRATE_P"}}).at("type"), "REAL32");
}

TEST(CasdCrash, AVehicleFliesOnThroughKillRestartAndReload) {
  FlightFixture fixture("log: {folder: $DIR, tlog: flight}\n");
  fixture.start_vehicle();
  fixture.start_casd();
  ASSERT_TRUE(fixture.fly_to(5));

  for (int round = 1; round <= 3; ++round) {
    fixture.casd().signal(SIGKILL);
    fixture.connect();
    expect_flying(fixture, "kill " + std::to_string(round));
    EXPECT_EQ(logs_in(fixture.folder.path()), round + 1) << "the older log was written over";
  }
  fixture.casd().restart();
  fixture.connect();
  expect_flying(fixture, "restart");

  fixture.casd().reload();
  ASSERT_TRUE(wait_until(
      [&] { return fixture.casd().output().find("topology reloaded") != std::string::npos; }));
  expect_flying(fixture, "reload");
  EXPECT_EQ(fixture.casd().starts(), 5);
  EXPECT_TRUE(fixture.land());
}

/// WatchdogSec and TimeoutStopSec of the unit: a hung casd is ended and started again.
TEST(CasdCrash, ACasdThatStandsStillIsReplaced) {
  FlightFixture fixture;
  fixture.start_casd();
  fixture.casd().signal(SIGSTOP);
  ASSERT_TRUE(wait_until([&] { return fixture.casd().starts() == 2; }, std::chrono::seconds(60)));
  fixture.connect();
  EXPECT_EQ(fixture.call("link.list").size(), 3U);
}

/// A simulator or a controller that dies in the air takes the flight with it (the state of the
/// world or of the estimator is gone), but the others go on, and the next flight needs no other
/// restart.
TEST(CasdCrash, ASimulatorOrControllerThatDiedFliesAgainWithoutAnyOtherRestart) {
  FlightFixture fixture;
  fixture.start_vehicle();
  fixture.start_casd();
  ASSERT_TRUE(fixture.fly_to(5));

  fixture.controller().signal(SIGKILL);
  ASSERT_TRUE(fixture.controller().wait_exit());
  fixture.start_controller();
  fixture.simulator().signal(SIGKILL);  // the vehicle lies where it fell: a new world
  ASSERT_TRUE(fixture.simulator().wait_exit());
  fixture.start_simulator();
  EXPECT_TRUE(fixture.fly_to(5)) << fixture.state().dump();

  EXPECT_TRUE(fixture.land());
  EXPECT_EQ(fixture.casd().starts(), 1);
}

}  // namespace
}  // namespace cas::test
