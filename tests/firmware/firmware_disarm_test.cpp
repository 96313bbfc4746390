// SPDX-License-Identifier: BSD-3-Clause
// Causes of the disarming of a vehicle that hils armed.
#include "tests/firmware/sitl_flight.hpp"

namespace cas::test {
namespace {

class FirmwareDisarm : public SitlFlight {};

bool is_armed_heartbeat(const mav::PacketView& packet) {
  const auto heartbeat = mav::decode<mv::Heartbeat>(packet);
  return heartbeat && packet.source == kVehicle &&
         has(heartbeat->base_mode, mv::MavModeFlag::kSafetyArmed);
}

mv::CommandLong command_to_vehicle(mv::MavCmd id, float param1 = 0, float param2 = 0) {
  mv::CommandLong command;
  command.target_system = command.target_component = 1;
  command.command = id;
  command.param1 = param1;
  command.param2 = param2;
  return command;
}

struct Kill {
  const char* name;
  mv::MavCmd command;
  float param1;
  float param2;
  const char* words;
};

class FirmwareDisarmByStation : public FirmwareDisarm, public testing::WithParamInterface<Kill> {};

TEST_P(FirmwareDisarmByStation, IsNotUndone) {
  const Kill& kill = GetParam();
  start("taciturn");
  const auto code = fly([&](const mav::PacketView& packet) {
    if (!is_armed_heartbeat(packet)) return;
    say(command_to_vehicle(kill.command, kill.param1, kill.param2));
  });
  EXPECT_EQ(code, 1) << output();
  EXPECT_TRUE(says("the vehicle was disarmed from outside (255/190 on link gcs: " +
                   std::string(kill.words) + ")"))
      << output();
  EXPECT_TRUE(says("hils does not arm it again")) << output();
  EXPECT_EQ(armings(), 1) << output();
}

INSTANTIATE_TEST_SUITE_P(Commands, FirmwareDisarmByStation,
                         testing::Values(Kill{"Disarm", mv::MavCmd::kComponentArmDisarm, 0, 0,
                                              "command 400 (disarm)"},
                                         Kill{"ForcedDisarm", mv::MavCmd::kComponentArmDisarm, 0,
                                              21196, "command 400 (disarm)"},
                                         Kill{"FlightTermination", mv::MavCmd::kDoFlighttermination,
                                              1, 0, "command 185 (end the flight)"}),
                         [](const auto& test) { return test.param.name; });

/// casd sees it only in the vehicle's answer.
TEST_F(FirmwareDisarm, ByAStationThatCasdDoesNotHearIsNotUndone) {
  const std::uint16_t port = free_port();
  UdpPeer other;
  other.set_remote(port);
  mav::Encoder as_other{{200, 190}};
  start("taciturn, '" + std::to_string(port) + "'");
  const auto code = fly([&](const mav::PacketView& packet) {
    if (!is_armed_heartbeat(packet)) return;
    other.send(as_other(command_to_vehicle(mv::MavCmd::kComponentArmDisarm)));
  });
  EXPECT_EQ(code, 1) << output();
  EXPECT_TRUE(
      says("the vehicle was disarmed from outside (200/190 on link px4: command 400 (arm or "
           "disarm), by the vehicle's answer to it); hils does not arm it again"))
      << output();
  EXPECT_EQ(armings(), 1) << output();
}

TEST_F(FirmwareDisarm, AtTheBoardIsNotUndone) {
  start("stopped");
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says("perhaps by a person: it does not say that it did so itself")) << output();
  EXPECT_EQ(armings(), 1) << output();
}

/// @param word  it refuses the first takeoffs, or accepts the first one and stays where it is
class FirmwareDisarmByItself : public FirmwareDisarm,
                               public testing::WithParamInterface<const char*> {};

TEST_P(FirmwareDisarmByItself, IsUndone) {
  start(GetParam());
  EXPECT_EQ(fly(), 0) << output();
  EXPECT_GE(armings(), 2) << output();
}

INSTANTIATE_TEST_SUITE_P(Words, FirmwareDisarmByItself, testing::Values("early", "idle"),
                         [](const auto& test) { return std::string(test.param); });

TEST_F(FirmwareDisarm, WhileAnAcceptedTakeoffDoesNotLiftIsNotUndone) {
  start("sleepy");
  int beats = 0;
  const auto code = fly([&](const mav::PacketView& packet) {
    if (!is_armed_heartbeat(packet) || ++beats < 5) return;
    say(command_to_vehicle(mv::MavCmd::kComponentArmDisarm));
  });
  EXPECT_EQ(code, 1) << output();
  EXPECT_TRUE(
      says("the vehicle was disarmed from outside (255/190 on link gcs: command 400 "
           "(disarm)); hils does not arm it again"))
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
