// SPDX-License-Identifier: BSD-3-Clause
// A vehicle that hils armed is disarmed before it takes off, or after its flight.
#include "tests/firmware/sitl_flight.hpp"

namespace cas::test {
namespace {

class FirmwareDisarm : public SitlFlight {};

bool is_armed_heartbeat(const mav::PacketView& packet) {
  const auto heartbeat = mav::decode<mv::Heartbeat>(packet);
  return heartbeat && packet.source == kVehicle &&
         has(heartbeat->base_mode, mv::MavModeFlag::kSafetyArmed);
}

mv::CommandLong command_to_vehicle(mv::MavCmd id) {
  mv::CommandLong command;
  command.target_system = command.target_component = 1;
  command.command = id;
  return command;
}

constexpr const char* kNotAgain = "hils does not arm it again: the flight has no verdict";

/// @param word  it refuses the first takeoffs, or accepts the first one and stays where it is
class FirmwareDisarmByItself : public FirmwareDisarm,
                               public testing::WithParamInterface<const char*> {};

TEST_P(FirmwareDisarmByItself, IsNotUndoneAndLeavesNoVerdict) {
  start(GetParam());
  EXPECT_EQ(fly(), 3) << output();
  EXPECT_TRUE(says("the vehicle was disarmed before it took off, during step 2 (takeoff)"))
      << output();
  EXPECT_TRUE(says(kNotAgain)) << output();
  EXPECT_EQ(armings(), 1) << output();
}

INSTANTIATE_TEST_SUITE_P(Words, FirmwareDisarmByItself, testing::Values("early", "idle"),
                         [](const auto& test) { return std::string(test.param); });

TEST_F(FirmwareDisarm, ByAStationIsNotUndoneAndIsTold) {
  start("stubborn");
  const auto code = fly([&](const mav::PacketView& packet) {
    if (is_armed_heartbeat(packet)) say(command_to_vehicle(mv::MavCmd::kComponentArmDisarm));
  });
  EXPECT_EQ(code, 3) << output();
  EXPECT_TRUE(says(kNotAgain)) << output();
  EXPECT_TRUE(says("ground station 255/190  command 400 (disarm)")) << output();
  EXPECT_EQ(armings(), 1) << output();
}

/// casd sees it only in the vehicle's answer.
TEST_F(FirmwareDisarm, ByAStationThatCasdDoesNotHearIsTold) {
  const std::uint16_t port = free_port();
  UdpPeer other;
  other.set_remote(port);
  mav::Encoder as_other{{200, 190}};
  start("stubborn, '" + std::to_string(port) + "'");
  const auto code = fly([&](const mav::PacketView& packet) {
    if (!is_armed_heartbeat(packet)) return;
    other.send(as_other(command_to_vehicle(mv::MavCmd::kComponentArmDisarm)));
  });
  EXPECT_EQ(code, 3) << output();
  EXPECT_TRUE(
      says("ground station 200/190  command 400 (arm or disarm), by the vehicle's answer to it"))
      << output();
  EXPECT_EQ(armings(), 1) << output();
}

TEST_F(FirmwareDisarm, OfTheScenarioIsFollowedByAnotherFlight) {
  start("plain", "", std::string(kOneFlight) + R"(  - arm: {timeout_s: 100}
  - takeoff: {altitude_m: 2, timeout_s: 200}
  - land: {timeout_s: 100}
)");
  EXPECT_EQ(fly(), 0) << output();
  EXPECT_EQ(armings(), 2) << output();
}

}  // namespace
}  // namespace cas::test
