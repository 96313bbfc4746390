// SPDX-License-Identifier: BSD-3-Clause
// A flight by casctl alone, in real time, through simulator, daemon, pseudo-terminal and emulated
// controller: wants a quiet machine.
#include <gtest/gtest.h>

#include "tests/loopback/emulator_fixture.hpp"
#include "tests/support/ended_with.hpp"

namespace cas::test {
namespace {

TEST(FlightVerbs, FlyAVehicleFromTheGroundAndBack) {
  EmulatorFixture fixture;
  fixture.start();
  fixture.start_simulator();
  ASSERT_TRUE(fixture.hears_the_vehicle()) << fixture.output();
  const auto expect_done = [&fixture](const std::vector<std::string>& verb, const char* says) {
    EXPECT_THAT(fixture.casctl(verb), EndedWith(0, says));
  };
  expect_done({"arm", "--wait"}, "armed");  // waits for the estimator, too
  expect_done({"takeoff", "2", "--wait"}, "airborne");
  expect_done({"hold"}, "holds position");
  expect_done({"goto", "2", "1", "-2.5", "90", "--wait"}, "there");
  expect_done({"doctor"}, "vehicle 1 is in HIL mode");
  expect_done({"mode", "HOLD", "--wait"}, "in mode HOLD");
  expect_done({"rtl"}, "returns to launch");
  expect_done({"land", "--wait"}, "landed");
  expect_done({"disarm", "--wait"}, "disarmed");
}

/// A verb's last words on a line with 115200 baud; it exits with 1.
std::string said_of_a_slow_line(const std::string& verb, const std::string& words) {
  EmulatorFixture fixture;
  fixture.start("{preset: baud_115200}", 115200);
  fixture.start_simulator();
  EXPECT_TRUE(fixture.hears_the_vehicle()) << fixture.output();
  Ended said;
  EXPECT_TRUE(wait_until([&] {
    said = fixture.casctl({verb});
    return said.code == 1 && said.output.find(words) != std::string::npos;
  })) << said.output;
  return said.output;
}

TEST(FlightVerbs, BudgetFindsALineThatIsTooSlow) { said_of_a_slow_line("budget", "TOO SLOW"); }

TEST(FlightVerbs, DoctorFindsALineThatIsTooSlow) {
  const std::string text = said_of_a_slow_line("doctor", "line fcu");
  EXPECT_NE(text.find("BAD"), std::string::npos) << text;
}

}  // namespace
}  // namespace cas::test
