// SPDX-License-Identifier: BSD-3-Clause
// Complaints of a vehicle that will not arm, and arming of stock firmware.
#include "casd/station/vehicle_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "casd/station/vehicle_commander.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "tests/casd/fake_vehicle.hpp"

namespace cas::casd::test {
namespace {

using namespace mavlink::common;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// A commander with one vehicle on virtual time.
class Stock : public testing::Test {
 protected:
  void pass(base::Duration time) {
    for (const base::RunTime end = now_ + time; now_ < end; now_ += milliseconds(10)) {
      while (const auto packet = vehicle_.take(now_)) {
        commander_.on_packet(LinkId{0}, mav::view_packet(packet->view()), now_);
      }
      commander_.tick(now_);
    }
  }
  void beat() {
    vehicle_.say_heartbeat(now_);
    pass(milliseconds(20));
  }
  template <class Message>
  void say(const Message& message) {
    vehicle_.say(message, now_);
    pass(milliseconds(20));
  }
  void say_sensors(MavSysStatusSensor present, MavSysStatusSensor health) {
    say_health(present, present, health);
  }
  void say_health(MavSysStatusSensor present, MavSysStatusSensor enabled,
                  MavSysStatusSensor health) {
    SysStatus status{.onboard_control_sensors_present = present,
                     .onboard_control_sensors_enabled = enabled,
                     .onboard_control_sensors_health = health};
    say(status);
  }
  std::vector<std::string> complaints_now() { return complaints(*commander_.find(1), now_); }
  std::optional<Outcome> arm(bool not_hil = false) {
    std::optional<Outcome> outcome;
    commander_.arm(1, {.not_hil = not_hil}, now_, [&](const Outcome& o) { outcome = o; });
    pass(seconds(3));
    return outcome;
  }

  using S = MavSysStatusSensor;
  static constexpr S kAll = S::k3dGyro | S::k3dAccel | S::k3dMag | S::kAbsolutePressure | S::kGps;

  FakeVehicle vehicle_;
  base::RunTime now_{seconds(10)};
  VehicleCommander commander_{{.allow_not_hil = true, .ask_on_sight = false},
                              [this](std::span<const std::uint8_t> packet, std::span<const Path>) {
                                vehicle_.handle(mav::view_packet(packet), now_);
                              }};
};

TEST_F(Stock, AHealthyVehicleHasNothingToComplainOf) {
  beat();
  EXPECT_TRUE(complaints_now().empty()) << "nothing said yet";
  say_sensors(kAll, kAll);
  EXPECT_TRUE(complaints_now().empty());
}

TEST_F(Stock, MissingAndSickSensorsAreNamed) {
  beat();
  say_sensors(S::k3dGyro | S::k3dAccel | S::kAbsolutePressure | S::kGps,
              S::k3dGyro | S::k3dAccel | S::kAbsolutePressure);
  EXPECT_EQ(complaints_now(), (std::vector<std::string>{"no magnetometer", "GPS not healthy"}));
  pass(seconds(6));
  EXPECT_TRUE(complaints_now().empty()) << "what it said has grown old";
}

TEST_F(Stock, ItsOwnReasonsCountAndChatterDoesNot) {
  beat();
  vehicle_.say_text("Preflight Fail: Found 0 compass (required: 1)", now_);
  vehicle_.say_text("Takeoff detected", now_);
  vehicle_.say_text("PreArm: GPS 1: Bad fix", now_);
  pass(milliseconds(50));
  EXPECT_EQ(complaints_now(),
            (std::vector<std::string>{"Preflight Fail: Found 0 compass (required: 1)",
                                      "PreArm: GPS 1: Bad fix"}));
}

TEST_F(Stock, ItsReasonsAreOverWhenItIsArmedOrWhenTheyAreOld) {
  beat();
  vehicle_.say_text("Preflight Fail: No valid GPS", now_);
  pass(milliseconds(50));
  EXPECT_EQ(complaints_now().size(), 1U);
  vehicle_.base_mode = vehicle_.base_mode | MavModeFlag::kSafetyArmed;
  beat();
  EXPECT_TRUE(complaints_now().empty());
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
  beat();
  pass(seconds(50));
  EXPECT_TRUE(complaints_now().empty());
}

TEST_F(Stock, ItsReasonsAreOverOnceItHasFlown) {
  beat();
  vehicle_.say_text("Arming denied! Check the preflight failures", now_);
  pass(milliseconds(50));
  vehicle_.base_mode = vehicle_.base_mode | MavModeFlag::kSafetyArmed;
  beat();
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
  beat();
  EXPECT_TRUE(complaints_now().empty()) << "45 s are not over yet";
  vehicle_.say_text("Preflight Fail: No valid GPS", now_);
  pass(milliseconds(50));
  EXPECT_EQ(complaints_now().size(), 1U) << "and this is new";
}

// PX4 v1.12.0.
TEST_F(Stock, ASensorThatIsHealthyIsThereWithoutTheBitThatSaysSo) {
  beat();
  SysStatus status{.onboard_control_sensors_present = S::k3dMag | S::kAbsolutePressure | S::kGps,
                   .onboard_control_sensors_enabled = kAll,
                   .onboard_control_sensors_health = kAll};
  say(status);
  EXPECT_TRUE(complaints_now().empty()) << testing::PrintToString(complaints_now());
}

// PX4 v1.16.1 without GPS, as recorded.
TEST_F(Stock, ASensorThatIsNeitherPresentNorEnabledIsMissing) {
  beat();
  SysStatus status{.onboard_control_sensors_health = kAll};
  say(status);
  EXPECT_TRUE(complaints_now().empty()) << "in its first second it tells of none";
  status.onboard_control_sensors_present = kAll & ~S::kGps;
  status.onboard_control_sensors_enabled = kAll & ~S::kGps;
  say(status);
  EXPECT_EQ(complaints_now(), std::vector<std::string>{"no GPS"});
  say(GpsRawInt{.fix_type = GpsFixType::k3dFix});
  EXPECT_TRUE(complaints_now().empty()) << "it is there, and the estimator does not use it";
}

// PX4 v1.16.1 ends its texts with a tab.
TEST_F(Stock, TextsComeWithoutTabs) {
  beat();
  vehicle_.say_text("Preflight Fail: No\tvalid GPS\t", now_);
  pass(milliseconds(50));
  EXPECT_EQ(complaints_now(), (std::vector<std::string>{"Preflight Fail: No valid GPS"}));
}

class StockPosition : public Stock {
 protected:
  std::string lack() { return position_lack(*commander_.find(1), now_); }
  void say_estimator(EstimatorStatusFlags flags) { say(EstimatorStatus{.flags = flags}); }
  void say_home() { say(HomePosition{}); }
  void say_fix(GpsFixType fix) { say(GpsRawInt{.fix_type = fix}); }
  using E = EstimatorStatusFlags;
  static constexpr E kFlies =
      E::kAttitude | E::kVelocityHoriz | E::kVelocityVert | E::kPosHorizAbs | E::kPosVertAbs;
};

TEST_F(StockPosition, OfPx4IsItsEstimatorsWordAndHome) {
  beat();
  EXPECT_EQ(lack(), "its estimator has not reported yet");
  say_fix(GpsFixType::k3dFix);
  say_home();
  EXPECT_EQ(lack(), "its estimator has not reported yet") << "a fix is no position";
  say_estimator(E::kAttitude | E::kVelocityHoriz | E::kVelocityVert | E::kConstPosMode);
  EXPECT_EQ(lack(), "the estimator has no horizontal position yet");
  say_estimator(kFlies | E::kConstPosMode);
  EXPECT_EQ(lack(), "") << "v1.16.0 and later: it stands still";
}

TEST_F(StockPosition, NeedsHome) {
  beat();
  say_estimator(kFlies);
  EXPECT_EQ(lack(), "it has not told its home position yet");
  say_home();
  EXPECT_EQ(lack(), "");
}

TEST_F(StockPosition, IsAFixWhereTheEstimatorHasNotSpokenForTenHeartbeats) {
  beat();
  say_home();
  for (int i = 0; i < 9; ++i) {
    say_fix(GpsFixType::k3dFix);
    EXPECT_EQ(lack(), "its estimator has not reported yet") << i;
    pass(seconds(1));
    beat();
  }
  say_fix(GpsFixType::kNoFix);
  EXPECT_EQ(lack(), "the GPS has no fix yet");
  say_fix(GpsFixType::k3dFix);
  EXPECT_EQ(lack(), "");
}

// PX4 1.13 to 1.18 as recorded: "enabled" never has the bit.
TEST_F(StockPosition, OfPx4NeedsTheChecksThatItReportsAsHealthAlone) {
  beat();
  say_home();
  say_estimator(kFlies);
  say_sensors(kAll, kAll);
  EXPECT_EQ(arming_checks(*commander_.find(1), now_), ArmingChecks::kUnknown)
      << "a PX4 of an unknown version, perhaps v1.12, which has no such bit";
  EXPECT_EQ(lack(), "");
  say(AutopilotVersion{.flight_sw_version = 1U << 24 | 16U << 16 | 1U << 8});
  EXPECT_EQ(arming_checks(*commander_.find(1), now_), ArmingChecks::kFail);
  EXPECT_EQ(lack(), "its arming checks fail");
  say_health(kAll, kAll, kAll | S::kPrearmCheck);
  EXPECT_EQ(arming_checks(*commander_.find(1), now_), ArmingChecks::kPass);
  EXPECT_EQ(lack(), "");
}

TEST_F(StockPosition, OfAPx4ThatHasPassedItsChecksIsGoneWhenTheyFail) {
  beat();
  say_home();
  say_estimator(kFlies);
  say_health(kAll, kAll, kAll | S::kPrearmCheck);
  EXPECT_EQ(lack(), "");
  say_health(kAll, kAll, kAll & ~S::kGps);
  EXPECT_EQ(lack(), "its arming checks fail; GPS not healthy");
}

TEST_F(StockPosition, NamesTheSensorsThatAreMissing) {
  beat();
  say_estimator(E::kAttitude);
  say_sensors(kAll & ~S::kGps, kAll & ~S::kGps);
  EXPECT_EQ(lack(), "the estimator has no velocity yet; no GPS");
}

TEST_F(StockPosition, OfArduPilotIsItsEkfReport) {
  vehicle_.autopilot = MavAutopilot::kArdupilotmega;
  beat();
  say_home();
  say_fix(GpsFixType::k3dFix);
  const auto report = [this](std::uint8_t low, std::uint8_t high) {
    // EKF_STATUS_REPORT: five floats, then the flags.
    std::vector<std::uint8_t> payload(22);
    payload[20] = low;
    payload[21] = high;
    const mav::PacketView packet{
        .version = 2, .source = {1, 1}, .message_id = kEkfStatusReport, .payload = payload};
    commander_.on_packet(LinkId{0}, packet, now_);
  };
  report(0xA7, 0x02);  // attitude, velocity, height, constant position
  EXPECT_EQ(lack(), "the estimator has no horizontal position yet");
  report(0x3F, 0x03);
  EXPECT_EQ(lack(), "");
}

TEST_F(StockPosition, OfBeforeARestartDoesNotCount) {
  beat();
  Attitude attitude;
  attitude.time_boot_ms = 60'000;
  vehicle_.say(attitude, now_);
  say_estimator(kFlies);
  say_home();
  EXPECT_EQ(lack(), "");
  attitude.time_boot_ms = 500;
  say(attitude);
  EXPECT_NE(lack(), "");
}

TEST_F(StockPosition, OfBeforeASilenceDoesNotCount) {
  beat();
  say_estimator(kFlies);
  say_home();
  EXPECT_EQ(lack(), "");
  pass(seconds(5));
  beat();
  EXPECT_NE(lack(), "") << "it may have been started anew";
  say_estimator(kFlies);
  say_home();
  EXPECT_EQ(lack(), "");
}

TEST_F(StockPosition, DoesNotOutliveTheStreamThatToldIt) {
  beat();
  say_estimator(kFlies);
  say_home();
  for (int i = 0; i < 12; ++i) {
    pass(seconds(1));
    beat();
  }
  EXPECT_EQ(lack(), "it tells nothing of its estimator and GPS");
}

TEST_F(StockPosition, IsAFixAgainWhereTheEstimatorSpokeOnceOnly) {
  beat();
  say_estimator(E::kAttitude);
  say_home();
  for (int i = 0; i < 12; ++i) {
    pass(seconds(1));
    beat();
    say_fix(GpsFixType::k3dFix);
  }
  EXPECT_EQ(lack(), "");
}

TEST_F(StockPosition, GoesByTheClockOfASlowVehicle) {
  beat();
  say_estimator(kFlies);
  say_home();
  for (int i = 0; i < 20; ++i) {  // at a fifth of real time
    pass(seconds(1));
    vehicle_.say(Attitude{}, now_);
    if (i % 5 == 4) beat();
  }
  EXPECT_EQ(lack(), "");
}

TEST_F(StockPosition, OfAnotherKindOfAutopilotIsNotAskedFor) {
  vehicle_.autopilot = MavAutopilot::kGeneric;
  beat();
  EXPECT_EQ(lack(), "");
}

TEST_F(Stock, AVehicleAtTwentyTimesRealTimeHearsItsGroundStationByItsOwnClock) {
  beat();
  const int before = vehicle_.heartbeats;
  for (int i = 0; i < 100; ++i) {
    Attitude attitude;
    attitude.time_boot_ms = static_cast<std::uint32_t>(2000 * i / 10);  // 20 s of its own
    vehicle_.say(attitude, now_);
    pass(milliseconds(10));
  }
  EXPECT_GE(vehicle_.heartbeats - before, 9);
  EXPECT_LE(vehicle_.heartbeats - before, 12);
}

TEST_F(Stock, AVehicleInRealTimeHearsItsGroundStationOnceASecond) {
  beat();
  const int before = vehicle_.heartbeats;
  for (int i = 0; i < 1000; ++i) {
    Attitude attitude;
    attitude.time_boot_ms = static_cast<std::uint32_t>(10 * i);
    vehicle_.say(attitude, now_);
    pass(milliseconds(10));
  }
  EXPECT_EQ(vehicle_.heartbeats - before, 10);
}

TEST(StockBeat, AVehicleThatRacesDrawsNoHeartbeatToTheOthers) {
  FakeVehicle vehicle;
  base::RunTime now{seconds(10)};
  int to_all = 0;
  int to_it = 0;
  VehicleCommander commander({.ask_on_sight = false}, [&](std::span<const std::uint8_t> packet,
                                                          std::span<const Path> paths) {
    if (mav::view_packet(packet).message_id != Heartbeat::kId) return;
    ++(paths.empty() ? to_all : to_it);
    for (const Path& path : paths) EXPECT_EQ(path.link, LinkId{3});
  });
  vehicle.say_heartbeat(now);
  for (int i = 0; i < 100; ++i, now += milliseconds(10)) {
    Attitude attitude;
    attitude.time_boot_ms = static_cast<std::uint32_t>(2000 * i / 10);  // 20 s of its own
    vehicle.say(attitude, now);
    while (const auto packet = vehicle.take(now)) {
      commander.on_packet(LinkId{3}, mav::view_packet(packet->view()), now);
    }
    commander.tick(now);
  }
  EXPECT_EQ(to_all, 1);
  EXPECT_GE(to_it, 8);
  EXPECT_LE(to_it, 11);
}

TEST_F(Stock, ARefusalToArmTellsWhatIsSickAndWhatWasSaidSinceItWasAsked) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
  vehicle_.custom_mode = 3U << 24 | 4U << 16;  // HOLD
  beat();
  vehicle_.say_text("Preflight Fail: Compass not found", now_);
  say_sensors(kAll, S::k3dGyro | S::k3dAccel | S::k3dMag | S::kAbsolutePressure);
  vehicle_.script.result = MavResult::kTemporarilyRejected;
  vehicle_.script.text = "Arming denied! Check the preflight failures";
  vehicle_.say_text("Preflight Fail: No valid GPS", now_ + milliseconds(100));  // while it is asked
  const auto outcome = arm();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->kind, OutcomeKind::kRefused);
  EXPECT_EQ(outcome->message.find("Compass"), std::string::npos) << outcome->message;
  EXPECT_NE(outcome->message.find("No valid GPS"), std::string::npos) << outcome->message;
  EXPECT_NE(outcome->message.find("GPS not healthy"), std::string::npos) << outcome->message;
  EXPECT_NE(outcome->message.find("Arming denied"), std::string::npos) << outcome->message;
}

TEST_F(Stock, RefusedInAModeThatWantsSticksItIsPutIntoHoldAndAskedAgain) {
  vehicle_.custom_mode = 1U << 16;  // MANUAL
  beat();
  vehicle_.script.result = MavResult::kDenied;
  std::optional<Outcome> outcome;
  commander_.arm(1, {}, now_, [&](const Outcome& o) { outcome = o; });
  pass(milliseconds(100));
  vehicle_.script.result = MavResult::kAccepted;  // in HOLD it will
  pass(milliseconds(500));
  beat();
  pass(seconds(1));
  ASSERT_TRUE(outcome);
  EXPECT_TRUE(outcome->ok()) << outcome->message;
  std::vector<MavCmd> sent;
  for (const CommandLong& command : vehicle_.commands) {
    if (command.command != MavCmd::kRequestMessage) sent.push_back(command.command);
  }
  EXPECT_EQ(sent, (std::vector<MavCmd>{MavCmd::kComponentArmDisarm, MavCmd::kDoSetMode,
                                       MavCmd::kComponentArmDisarm}));
  EXPECT_FLOAT_EQ(vehicle_.commands[1].param2, 4);
  EXPECT_FLOAT_EQ(vehicle_.commands[1].param3, 3);
}

/// Requests to an ArduPilot that sends for 5 s, from this moment on.
std::vector<float> asked_for(VehicleCommander& commander, FakeVehicle& vehicle, base::RunTime now) {
  vehicle.commands.clear();
  for (base::RunTime t = now; t < now + seconds(5); t += milliseconds(10)) {
    if ((t - now) % seconds(1) == base::Duration{}) vehicle.say_heartbeat(t);
    while (const auto packet = vehicle.take(t)) {
      commander.on_packet(LinkId{0}, mav::view_packet(packet->view()), t);
    }
    commander.tick(t);
  }
  std::vector<float> asked;
  for (const CommandLong& command : vehicle.commands) {
    if (command.command == MavCmd::kSetMessageInterval) asked.push_back(command.param1);
  }
  return asked;
}

TEST(StockArduPilot, IsAskedForTheStreamsThatItDoesNotSendByItself) {
  FakeVehicle vehicle;
  vehicle.autopilot = MavAutopilot::kArdupilotmega;
  const base::RunTime now{seconds(10)};
  VehicleCommander commander({}, [&](std::span<const std::uint8_t> packet, std::span<const Path>) {
    vehicle.handle(mav::view_packet(packet), now);
  });
  const std::vector<float> asked = asked_for(commander, vehicle, now);
  for (const std::uint32_t id : {LocalPositionNed::kId, ExtendedSysState::kId, SysStatus::kId}) {
    EXPECT_NE(std::find(asked.begin(), asked.end(), static_cast<float>(id)), asked.end()) << id;
  }
  EXPECT_EQ(asked_for(commander, vehicle, now + seconds(20)), asked) << "it was started anew";
}

TEST(StockArduPilot, IsAskedForTheRatesOfItsLinkAloneWhereCasdAsksForNothing) {
  FakeVehicle vehicle;
  vehicle.autopilot = MavAutopilot::kArdupilotmega;
  const base::RunTime now{seconds(10)};
  CommanderOptions options{.ask_on_sight = false, .request_rates = [](LinkId) {
                             return std::vector<MessageRate>{{Attitude::kId, 4}};
                           }};
  VehicleCommander commander(options,
                             [&](std::span<const std::uint8_t> packet, std::span<const Path>) {
                               vehicle.handle(mav::view_packet(packet), now);
                             });
  EXPECT_EQ(asked_for(commander, vehicle, now), std::vector<float>{Attitude::kId});
  EXPECT_EQ(vehicle.commands.size(), 1U) << "and for no AUTOPILOT_VERSION";
  commander.set_commanding(0, false, true);
  EXPECT_GT(asked_for(commander, vehicle, now + seconds(20)).size(), 5U) << "by a reload";
}

TEST(StockArduPilot, IsAskedAgainThatIsBackBeforeItsHeartbeatWasMissed) {
  FakeVehicle vehicle;
  vehicle.autopilot = MavAutopilot::kArdupilotmega;
  base::RunTime now{seconds(10)};
  VehicleCommander commander({}, [&](std::span<const std::uint8_t> packet, std::span<const Path>) {
    vehicle.handle(mav::view_packet(packet), now);
  });
  const std::vector<float> asked = asked_for(commander, vehicle, now);
  now += seconds(5);
  vehicle.say(Attitude{}, now);
  for (const int second : {1, 2, 3, 4}) vehicle.say(ParamValue{}, now + seconds(second));
  EXPECT_EQ(asked_for(commander, vehicle, now), asked) << "it only answers from then on";
  now += seconds(5);
  EXPECT_TRUE(asked_for(commander, vehicle, now).empty()) << "asked once";
}

TEST_F(Stock, FirmwareInSoftwareIsArmedByConsentOnly) {
  vehicle_.base_mode = MavModeFlag::kCustomModeEnabled;  // never says HIL
  beat();
  const auto refused = arm();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->kind, OutcomeKind::kInterlock);
  EXPECT_NE(refused->message.find("--not-hil"), std::string::npos) << refused->message;
  beat();
  const auto armed = arm(true);
  ASSERT_TRUE(armed);
  EXPECT_TRUE(armed->ok()) << armed->message;
}

}  // namespace
}  // namespace cas::casd::test
