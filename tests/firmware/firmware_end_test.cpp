// SPDX-License-Identifier: BSD-3-Clause
// Firmware that is not there, is never heard, is another one, or dies.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/firmware/sitl_flight.hpp"

namespace cas::test {
namespace {

class FirmwareEnd : public SitlFlight {};

TEST_F(FirmwareEnd, InFlightIsAFailedFlightWithItsReports) {
  start("dies");
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says("firmware was ended by signal 6 (Aborted); its last lines:")) << output();
  EXPECT_TRUE(says("scripted: a bug")) << output();
  EXPECT_NE(left("junit.xml").find("was ended by signal 6"), std::string::npos);
  EXPECT_NE(left("report.html").find("was ended by signal 6"), std::string::npos);
  EXPECT_FALSE(summary().at("passed").get<bool>());
  EXPECT_FALSE(says("a hint of the scenario")) << "it was heard: its airframe is right";
}

TEST_F(FirmwareEnd, BeforeItsFirstHeartbeatHasNoVerdictAndGivesTheHint) {
  start("too, many, words");
  EXPECT_EQ(fly(), 3) << output();
  EXPECT_TRUE(says("firmware ended with exit code 2; its last lines:")) << output();
  EXPECT_TRUE(says("a hint of the scenario")) << output();
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out/summary.json"));
}

TEST_F(FirmwareEnd, OfAFirmwareThatNeverConnectsIsNotWaitedForToTheEnd) {
  command_ = "[/bin/sh, -c, 'echo waits for a key; exec sleep 600']";
  first_step_ = "  - arm: {timeout_s: 500}\n";
  const base::RunTime begin = base::steady_now();
  start("");
  EXPECT_EQ(fly(), 3) << output();
  EXPECT_LT(base::to_seconds(base::steady_now() - begin), 120);
  EXPECT_TRUE(says("the firmware was not heard within ")) << output();
  EXPECT_TRUE(says("nobody connected to tcp 127.0.0.1:" + ports_.simulator)) << output();
  EXPECT_TRUE(says("nothing on link px4 (")) << output();
  EXPECT_TRUE(says("waits for a key")) << output();
}

TEST_F(FirmwareEnd, OfAProgramThatIsNotThereComesBeforeAnythingStarts) {
  command_ = "[/no/such/px4]";
  start("");
  EXPECT_EQ(fly(), 2) << output();
  EXPECT_TRUE(
      says("firmware.command: cannot start '/no/such/px4': No such file or directory (errno 2)"))
      << output();
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out/run/casd.log"));
}

TEST_F(FirmwareEnd, OfAnotherAutopilotIsSaidAfterItsFirstHeartbeat) {
  start("ardupilot");
  EXPECT_EQ(fly(), 3) << output();
  EXPECT_TRUE(says("the scenario's world is for PX4, and the first HEARTBEAT is of ArduPilot"))
      << output();
}

TEST_F(FirmwareEnd, OfAPlaneInTheWorldOfACopterIsSaidAfterItsFirstHeartbeat) {
  start("plane");
  EXPECT_EQ(fly(), 3) << output();
  EXPECT_TRUE(says("by its first HEARTBEAT the firmware flies a fixed_wing")) << output();
}

TEST_F(FirmwareEnd, OfAnEarlierFlightLeavesNoParametersBehind) {
  constexpr const char* kParam = "  - setparam: {MPC_Z_VEL_MAX_UP: 1.5}\n";
  first_step_ = std::string(kParam) + first_step_;
  start("obedient");
  ASSERT_EQ(fly(), 0) << output();
  ASSERT_NE(left("run/firmware/parameters").find("MPC_Z_VEL_MAX_UP 1.5"), std::string::npos);
  const auto first = summary().at("parameters");
  first_step_ = "  - arm: {timeout_s: 100}\n";
  start("obedient");
  ASSERT_EQ(fly(), 0) << output();
  EXPECT_EQ(left("run/firmware/parameters").find("MPC_Z_VEL_MAX_UP 1.5"), std::string::npos);
  EXPECT_EQ(summary().at("parameters"), first)
      << "both began with the parameters that the firmware comes with";
  EXPECT_GT(first.at("count").get<int>(), 50);
}

TEST_F(FirmwareEnd, OfAFlightInAFolderThatIsNotEmptyIsRemarked) {
  const auto folder = folder_.path() / "px4";
  folder_.write("px4/parameters", "MPC_Z_VEL_MAX_UP 1.5\n");
  cwd_ = folder.string();
  start("obedient");
  ASSERT_EQ(fly(), 0) << output();
  const std::string remark = "the firmware's folder " + folder.string() + " was not empty";
  EXPECT_TRUE(says("note: " + remark)) << output();
  EXPECT_NE(left("summary.json").find(remark), std::string::npos);
  EXPECT_NE(left("report.html").find("was not empty"), std::string::npos);
}

}  // namespace
}  // namespace cas::test
