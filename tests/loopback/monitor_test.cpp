// SPDX-License-Identifier: BSD-3-Clause
// `casctl monitor` on a terminal of its own, through the real casd, beside the emulated controller.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/loopback/emulator_fixture.hpp"
#include "tests/support/terminal_program.hpp"

namespace cas::test {
namespace {

class Monitor : public testing::Test {
 protected:
  void open(std::size_t rows, std::size_t columns) {
    monitor = std::make_unique<TerminalProgram>(
        std::vector<std::string>{cas::test::binary_dir() + "/bin/casctl", "--address",
                                 "unix:" + fixture.socket(), "monitor"},
        rows, columns);
  }
  /// With the vehicle, as soon as its state is known.
  void open_with_vehicle(std::size_t rows, std::size_t columns) {
    fixture.start();
    ASSERT_TRUE(fixture.hears_the_vehicle()) << fixture.output();
    open(rows, columns);
    ASSERT_TRUE(monitor->shows("vehicle 1")) << monitor->text();
  }
  const std::string& title() { return monitor->screen().front(); }

  EmulatorFixture fixture;
  std::unique_ptr<TerminalProgram> monitor;
};

TEST_F(Monitor, SaysAtOnceThatThereIsNoVehicleAndWhichLinksAreUp) {
  fixture.start_casd((fixture.folder / "nowhere").string(), 0);
  open(24, 80);
  ASSERT_TRUE(monitor->shows("? help")) << monitor->text();
  EXPECT_NE(title().find("NO VEHICLE"), std::string::npos) << monitor->text();
  EXPECT_TRUE(monitor->shows("links up: sim; down: fcu")) << monitor->text();
  EXPECT_EQ(monitor->text().find("in_air"), std::string::npos);
  monitor->resize(50, 180);
  ASSERT_TRUE(monitor->shows(" | VEHICLE")) << monitor->text();
  EXPECT_TRUE(monitor->shows("No vehicle: no gains.")) << monitor->text();
  monitor->press("q");
  EXPECT_EQ(monitor->wait_exit(), 0);
}

TEST_F(Monitor, ShowsTheVehicleInOnePaneAndInTwo) {
  open_with_vehicle(24, 80);
  EXPECT_TRUE(monitor->shows("HIL  disarmed")) << monitor->text();
  EXPECT_TRUE(monitor->shows("HEARTBEAT")) << monitor->text();
  EXPECT_EQ(monitor->text().find(" | "), std::string::npos) << monitor->text();
  monitor->resize(50, 180);
  ASSERT_TRUE(monitor->shows(" | VEHICLE 1")) << monitor->text();
  EXPECT_TRUE(monitor->shows("heading")) << monitor->text();
  EXPECT_TRUE(monitor->shows("rollrate")) << monitor->text();  // the gains come by themselves
}

TEST_F(Monitor, TakesTypedCommandsWithCompletionAndShowsTheirAnswers) {
  open_with_vehicle(24, 80);
  monitor->press(":mo");
  ASSERT_TRUE(monitor->shows(": mo\n")) << monitor->text();
  monitor->press("\thol\t");
  ASSERT_TRUE(monitor->shows(": mode HOLD\n")) << monitor->text();
  monitor->press("\r");
  EXPECT_TRUE(monitor->shows("mode HOLD: ACCEPTED")) << monitor->text();
  monitor->press(":param set MC_ROLL_P 6.4\r");
  EXPECT_TRUE(monitor->shows("MC_ROLL_P = 7 -> 6.4")) << monitor->text();
  monitor->press(":param get MC_ROLLRATE\t");  // asks the vehicle for the names
  EXPECT_TRUE(monitor->shows("MC_ROLLRATE_I")) << monitor->text();
  monitor->press("\x1b");
  ASSERT_TRUE(monitor->shows("? help")) << monitor->text();
  monitor->press(":arm\r");
  EXPECT_TRUE(monitor->shows("no accelerometer and gyro data")) << monitor->text();
  monitor->press(":fly\r");
  EXPECT_TRUE(monitor->shows("there is no command 'fly'")) << monitor->text();
}

TEST_F(Monitor, SaysThatAVehicleIsLostAndWhenCasdIsSilent) {
  open_with_vehicle(24, 80);
  fixture.kill_controller();
  EXPECT_TRUE(monitor->shows("LOST since")) << monitor->text();
  EXPECT_TRUE(monitor->shows("no HEARTBEAT since")) << monitor->text();
  fixture.kill_casd();
  EXPECT_TRUE(monitor->shows("CASD DOES NOT ANSWER since")) << monitor->text();
  EXPECT_EQ(title().find("disarmed"), std::string::npos) << monitor->text();
}

TEST_F(Monitor, OpensAMessageToItsPlotAndShowsHelpOnEightyByTwentyFour) {
  open_with_vehicle(24, 80);
  ASSERT_TRUE(monitor->shows(" ATTITUDE ")) << monitor->text();
  monitor->press("/attitude\r\r");
  EXPECT_TRUE(monitor->shows("ATTITUDE on fcu from 1/1")) << monitor->text();
  EXPECT_TRUE(monitor->shows("roll in rad")) << monitor->text();
  EXPECT_TRUE(monitor->shows("-10 s")) << monitor->text();
  monitor->press("?");
  EXPECT_TRUE(monitor->shows("quit")) << monitor->text();
  EXPECT_EQ(monitor->text().find("show the rest"), std::string::npos) << monitor->text();
}

}  // namespace
}  // namespace cas::test
