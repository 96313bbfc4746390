// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "tests/casd/station/commander_fixture.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using namespace std::chrono_literals;
using test::VehicleCommanderTest;

TEST_F(VehicleCommanderTest, Px4TakesOffToAnAltitudeAboveSeaLevel) {
  meet();
  say(HomePosition{.altitude = 488'000});
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 2.5).ok());
  ASSERT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_EQ(vehicle_.commands[0].command, MavCmd::kNavTakeoff);
  EXPECT_FLOAT_EQ(vehicle_.commands[0].param7, 490.5F);
  EXPECT_TRUE(std::isnan(vehicle_.commands[0].param5));
}

/// PX4 whose home is unknown.
class TakeoffByParameter : public VehicleCommanderTest {
 protected:
  TakeoffByParameter() {
    vehicle_.params["MIS_TAKEOFF_ALT"] = {.value = 10};
    meet();
  }
  double height() { return vehicle_.params["MIS_TAKEOFF_ALT"].value; }
  void be(MavLandedState landed) {
    say(ExtendedSysState{.landed_state = landed});
    run_for(1s);
  }
};

TEST_F(TakeoffByParameter, IsOfPx4WhileHomeIsUnknown) {
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 2.5).ok());
  EXPECT_FLOAT_EQ(static_cast<float>(height()), 2.5F);
  ASSERT_EQ(vehicle_.commands.size(), 1U);
  EXPECT_TRUE(std::isnan(vehicle_.commands[0].param7));

  be(MavLandedState::kOnGround);
  EXPECT_EQ(height(), 2.5) << "it has not begun to climb";
  be(MavLandedState::kTakeoff);
  EXPECT_EQ(height(), 10) << "what its owner wrote";
}

TEST_F(TakeoffByParameter, ThatIsRefusedLeavesTheParameterAsItWas) {
  vehicle_.script.result = MavResult::kDenied;
  EXPECT_EQ(ask(&VehicleCommander::takeoff, 2.5).kind, OutcomeKind::kRefused);
  run_for(1s);
  EXPECT_EQ(vehicle_.param_sets.size(), 2U);
  EXPECT_EQ(height(), 10);
}

TEST_F(TakeoffByParameter, ThatIsNotAcknowledgedLeavesTheParameterAsItWas) {
  vehicle_.script.answers = 0;
  EXPECT_EQ(ask(&VehicleCommander::takeoff, 2.5).kind, OutcomeKind::kTimeout);
  run_for(1s);
  EXPECT_EQ(height(), 10);
}

TEST_F(TakeoffByParameter, ThatEndsDisarmedLeavesTheParameterAsItWas) {
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 2.5).ok());
  run_for(2s);
  EXPECT_EQ(height(), 2.5) << "it may yet be armed";
  vehicle_.base_mode = vehicle_.base_mode | MavModeFlag::kSafetyArmed;
  run_for(2s);
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
  run_for(3s);
  EXPECT_EQ(height(), 10);
}

TEST_F(TakeoffByParameter, LeavesANewerHeight) {
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 2.5).ok());
  EXPECT_TRUE(ask(&VehicleCommander::set_param, "MIS_TAKEOFF_ALT", 7).ok());
  be(MavLandedState::kInAir);
  EXPECT_EQ(height(), 7);
}

TEST_F(TakeoffByParameter, AtOnceAfterARefusedOneKnowsTheOwnersHeight) {
  vehicle_.script.result = MavResult::kDenied;
  EXPECT_EQ(ask(&VehicleCommander::takeoff, 2.5).kind, OutcomeKind::kRefused);
  vehicle_.script.result = MavResult::kAccepted;
  // The put-back is on its way.
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 3).ok());
  EXPECT_EQ(height(), 3);
  be(MavLandedState::kInAir);
  EXPECT_EQ(height(), 10);
}

TEST_F(VehicleCommanderTest, ArduPilotTakesOffInGuidedToAHeightAboveHome) {
  vehicle_.autopilot = MavAutopilot::kArdupilotmega;
  meet();
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 2.5).ok());
  EXPECT_EQ(vehicle_.commands.front().command, MavCmd::kDoSetMode);
  EXPECT_EQ(vehicle_.commands.front().param2, 4.0F);  // GUIDED
  EXPECT_EQ(vehicle_.commands.back().command, MavCmd::kNavTakeoff);
  EXPECT_EQ(vehicle_.commands.back().param7, 2.5F);
}

/// The newest mode that a vehicle of ArduPilot was asked for; -1: none. A question for its
/// HEARTBEAT follows the command.
float asked_mode(const test::FakeVehicle& vehicle) {
  float mode = -1;
  for (const CommandLong& command : vehicle.commands) {
    if (command.command == MavCmd::kDoSetMode) mode = command.param2;
  }
  return mode;
}

class ArduPlane : public VehicleCommanderTest {
 protected:
  ArduPlane() {
    vehicle_.autopilot = MavAutopilot::kArdupilotmega;
    vehicle_.type = MavType::kFixedWing;  // of quadplanes, too
    vehicle_.params["TKOFF_ALT"] = {.value = 50};
    meet();
  }
  void fly_as(MavVtolState state) {
    say(ExtendedSysState{.vtol_state = state, .landed_state = MavLandedState::kInAir});
  }
};

TEST_F(ArduPlane, ClimbsInTheModeTakeoffToItsParameter) {
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 40).ok());
  EXPECT_EQ(asked_mode(vehicle_), 13);
  vehicle_.base_mode = vehicle_.base_mode | MavModeFlag::kSafetyArmed;
  fly_as(MavVtolState::kUndefined);
  run_for(2s);
  EXPECT_EQ(vehicle_.params["TKOFF_ALT"].value, 40) << "the mode reads it until the climb ends";
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
  run_for(3s);
  EXPECT_EQ(vehicle_.params["TKOFF_ALT"].value, 50) << "the value from before";
}

TEST_F(ArduPlane, OnRotorsTakesOffInGuidedAndLandsInQland) {
  fly_as(MavVtolState::kMc);
  EXPECT_TRUE(ask(&VehicleCommander::takeoff, 20).ok());
  EXPECT_EQ(asked_mode(vehicle_), 15);
  EXPECT_EQ(vehicle_.commands.back().command, MavCmd::kNavTakeoff);
  EXPECT_EQ(vehicle_.params["TKOFF_ALT"].value, 50);
  EXPECT_TRUE(ask(&VehicleCommander::land).ok());
  EXPECT_EQ(asked_mode(vehicle_), 20);
}

TEST_F(ArduPlane, LandsWhereItsMissionSays) {
  EXPECT_TRUE(ask(&VehicleCommander::land).ok());
  EXPECT_EQ(vehicle_.commands.back().command, MavCmd::kDoLandStart);
}

struct HoldCase {
  const char* name;
  MavType type;
  MavVtolState vtol;
  float mode;
  const char* word;
};

class Hold : public VehicleCommanderTest, public testing::WithParamInterface<HoldCase> {};

// 17 is BRAKE of a copter, and a mode that wants sticks on a quadplane.
TEST_P(Hold, StaysInTheModeOfItsVehicle) {
  vehicle_.autopilot = MavAutopilot::kArdupilotmega;
  vehicle_.type = GetParam().type;
  meet();
  say(ExtendedSysState{.vtol_state = GetParam().vtol});
  EXPECT_TRUE(ask(&VehicleCommander::hold).ok());
  EXPECT_EQ(asked_mode(vehicle_), GetParam().mode);
  EXPECT_EQ(commander_.vehicles().front()->mode(), GetParam().word);
}

INSTANTIATE_TEST_SUITE_P(
    Vehicles, Hold,
    testing::Values(
        HoldCase{"Copter", MavType::kHexarotor, MavVtolState::kUndefined, 17, "BRAKE"},
        HoldCase{"Plane", MavType::kFixedWing, MavVtolState::kUndefined, 12, "LOITER"},
        HoldCase{"QuadplaneOnRotors", MavType::kFixedWing, MavVtolState::kMc, 19, "QLOITER"},
        HoldCase{"QuadplaneOnTheWing", MavType::kFixedWing, MavVtolState::kFw, 12, "LOITER"},
        HoldCase{"Vtol", MavType::kVtolFixedrotor, MavVtolState::kMc, 19, "QLOITER"},
        HoldCase{"Rover", MavType::kGroundRover, MavVtolState::kUndefined, 4, "HOLD"},
        HoldCase{"Boat", MavType::kSurfaceBoat, MavVtolState::kUndefined, 4, "HOLD"},
        HoldCase{"Submarine", MavType::kSubmarine, MavVtolState::kUndefined, 16, "POSHOLD"}),
    [](const auto& each) { return std::string(each.param.name); });

TEST_F(VehicleCommanderTest, AVehicleOfUnknownModesTakesNone) {
  vehicle_.autopilot = MavAutopilot::kArdupilotmega;
  vehicle_.type = MavType::kAntennaTracker;
  meet();
  EXPECT_EQ(ask(&VehicleCommander::set_mode, "GUIDED").kind, OutcomeKind::kInvalid);
  EXPECT_TRUE(vehicle_.commands.empty());
}

TEST_F(VehicleCommanderTest, GoesToALocalPlaceByLatitudeAndLongitude) {
  meet();
  HomePosition home{.latitude = 473977420, .longitude = 85455940, .altitude = 488'000};
  home.z = -0.5F;  // home lies 0.5 m above the origin of the local frame
  say(home);
  commander_.go_to(1, {.north_m = 111.19, .east_m = 0, .down_m = -3, .yaw_deg = 90}, now_, done());
  EXPECT_TRUE(finish().ok());
  ASSERT_EQ(vehicle_.int_commands.size(), 1U);
  const CommandInt& command = vehicle_.int_commands[0];
  EXPECT_EQ(command.command, MavCmd::kDoReposition);
  EXPECT_NEAR(command.x, 473977420 + 10000, 20);  // 111.19 m are a thousandth of a degree
  EXPECT_NEAR(command.y, 85455940, 1);
  EXPECT_FLOAT_EQ(command.z, 490.5F);
  EXPECT_FLOAT_EQ(command.param4, 1.5707964F);
  EXPECT_EQ(command.param2, 1.0F);
}

TEST_F(VehicleCommanderTest, TellsHowAVtolFlies) {
  meet();
  const auto word = [&](MavVtolState state) {
    say(ExtendedSysState{.vtol_state = state});
    return commander_.vehicles().front()->vtol_word();
  };
  EXPECT_EQ(word(MavVtolState::kMc), "multicopter");
  EXPECT_EQ(word(MavVtolState::kTransitionToFw), "to_plane");
  EXPECT_EQ(word(MavVtolState::kFw), "plane");
  EXPECT_EQ(word(MavVtolState::kTransitionToMc), "to_multicopter");
  EXPECT_EQ(word(MavVtolState::kUndefined), "");
}

struct CircleCase {
  const char* name;
  MavAutopilot autopilot;
  MavCmd command;
  int radius_param;
};

class Circle : public VehicleCommanderTest, public testing::WithParamInterface<CircleCase> {};

TEST_P(Circle, GoesWithItsRadiusToThePlace) {
  vehicle_.autopilot = GetParam().autopilot;
  meet();
  say(HomePosition{.latitude = 473977420, .longitude = 85455940, .altitude = 488'000});
  commander_.go_to(1, {.north_m = 0, .east_m = 0, .down_m = -40, .yaw_deg = {}, .radius_m = -80},
                   now_, done());
  EXPECT_TRUE(finish().ok());
  ASSERT_EQ(vehicle_.int_commands.size(), 1U);
  const CommandInt& command = vehicle_.int_commands[0];
  EXPECT_EQ(command.command, GetParam().command);
  EXPECT_EQ(GetParam().radius_param == 1 ? command.param1 : command.param3, -80.0F);
  EXPECT_FLOAT_EQ(command.z, 528.0F);
  EXPECT_NEAR(command.x, 473977420, 1);
}

INSTANTIATE_TEST_SUITE_P(
    Autopilots, Circle,
    testing::Values(CircleCase{"Px4AsAnOrbit", MavAutopilot::kPx4, MavCmd::kDoOrbit, 1},
                    CircleCase{"ArduPilotAsAReposition", MavAutopilot::kArdupilotmega,
                               MavCmd::kDoReposition, 3}),
    [](const auto& test) { return test.param.name; });

TEST_F(VehicleCommanderTest, RefusesPlacesNoVehicleReaches) {
  meet();
  say(HomePosition{.latitude = 473977420, .longitude = 85455940});
  commander_.go_to(1, {.north_m = 1e300, .yaw_deg = {}}, now_, done());
  EXPECT_EQ(finish().kind, OutcomeKind::kInvalid);
  EXPECT_EQ(ask(&VehicleCommander::takeoff, 1e300).kind, OutcomeKind::kInvalid);
  EXPECT_TRUE(vehicle_.commands.empty());
  EXPECT_TRUE(vehicle_.int_commands.empty());
}

TEST_F(VehicleCommanderTest, SaysWhyItCannotGoWithoutHome) {
  meet();
  commander_.go_to(1, {}, now_, done());
  EXPECT_EQ(finish().kind, OutcomeKind::kRefused);
}

}  // namespace
}  // namespace cas::casd
