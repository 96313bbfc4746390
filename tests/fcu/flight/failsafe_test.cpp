// SPDX-License-Identifier: BSD-3-Clause
// Each failsafe by a fault, in closed loop on a virtual clock.
#include <gtest/gtest.h>

#include <cmath>

#include "fcu/estimation/estimator.hpp"
#include "fcu/flight/commander.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/set_position_target_local_ned.hpp"
#include "mavlink/common/sys_status.hpp"
#include "tests/fcu/support/closed_loop.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::ClosedLoop;
using test::LoopOptions;

class FailsafeFlight : public testing::Test {
 protected:
  void hover() { ASSERT_TRUE(loop_.fly_to_hover(2.5)); }
  bool reaches(FlightMode mode, double at_most_s = 15) {
    return loop_.run_until([&] { return loop_.fcu().status().mode == mode; }, at_most_s);
  }
  bool lands(double at_most_s = 40) {
    return loop_.run_until([&] { return !loop_.fcu().status().armed; }, at_most_s);
  }
  ClosedLoop loop_{LoopOptions{}};
};

TEST_F(FailsafeFlight, WithoutGpsItDescendsLevelAndDisarms) {
  hover();
  loop_.gps_on = false;
  EXPECT_TRUE(reaches(FlightMode::kLand));
  EXPECT_TRUE(loop_.said("Position lost"));
  EXPECT_TRUE(lands());
  EXPECT_TRUE(loop_.multirotor().on_ground());
}

TEST_F(FailsafeFlight, AFixThatRepeatsToTheDigitIsALostGps) {
  hover();
  loop_.gps_frozen = true;
  EXPECT_TRUE(loop_.run_until([&] { return loop_.said("GPS repeats its last fix"); }, 3));
  EXPECT_TRUE(reaches(FlightMode::kLand, 6));
  EXPECT_TRUE(lands());
  EXPECT_LT(loop_.truth().p_N.head<2>().norm(), 10);
}

TEST_F(FailsafeFlight, FixesWhoseTimeStandsStillAreALostGps) {
  hover();
  loop_.gps_time_stands = true;
  EXPECT_TRUE(loop_.run_until([&] { return loop_.said("GPS repeats its last fix"); }, 3));
  EXPECT_TRUE(reaches(FlightMode::kLand, 6));
}

TEST_F(FailsafeFlight, AReceiverThatComesBackIsUsedAgain) {
  hover();
  loop_.gps_frozen = true;
  loop_.run(2);
  loop_.gps_frozen = false;
  loop_.run(10);
  EXPECT_EQ(loop_.fcu().status().mode, FlightMode::kHold);
  EXPECT_TRUE(loop_.fcu().estimator().position_valid());
}

TEST(RepeatedFix, OfAReceiverWithoutNoiseIsAMeasurementAtRest) {
  LoopOptions options;
  options.noise.gps_m = options.noise.gps_velocity_m_s = 0;
  options.configure = [](FcuConfig& config) {
    for (auto& [name, value] : config.params) {
      if (name.find("GPS") != std::string::npos) value = 0.3;
    }
  };
  ClosedLoop loop(options);
  EXPECT_TRUE(loop.fly_to_hover(2.5));
  loop.run(10);
  EXPECT_EQ(loop.fcu().status().mode, FlightMode::kHold);
  EXPECT_FALSE(loop.said("GPS repeats"));
}

TEST(RepeatedFix, KeepsFromArming) {
  ClosedLoop loop{LoopOptions{}};
  ASSERT_TRUE(loop.run_until([&] { return loop.fcu().status().estimator_ready; }, 20));
  loop.gps_frozen = true;
  loop.run(4);
  EXPECT_FALSE(loop.arm());
  loop.run(0.1);
  EXPECT_TRUE(loop.said("GPS repeats its last fix"));
}

TEST_F(FailsafeFlight, APositionThatJumpsIsToldAndLandsTheVehicle) {
  hover();
  loop_.noise().gps_offset_m.x() = 30;
  EXPECT_TRUE(reaches(FlightMode::kLand, 5));
  EXPECT_TRUE(loop_.said("GPS contradicted the estimate: landing"));
  EXPECT_TRUE(lands());
  EXPECT_LT(loop_.truth().p_N.head<2>().norm(), 5);
}

TEST_F(FailsafeFlight, AVelocityThatContradictsThePositionsIsToldAndNotUsed) {
  hover();
  loop_.noise().gps_velocity_offset_m_s.x() = 3;
  EXPECT_TRUE(loop_.run_until([&] { return loop_.said("GPS velocity contradicts"); }, 5));
  loop_.run(20);
  EXPECT_EQ(loop_.fcu().status().mode, FlightMode::kHold);
  EXPECT_LT(loop_.truth().p_N.head<2>().norm(), 3);
}

TEST(Arming, IsRefusedWhenTheVelocityOfGpsContradictsItsPositions) {
  ClosedLoop loop{LoopOptions{}};
  ASSERT_TRUE(loop.run_until([&] { return loop.fcu().status().estimator_ready; }, 20));
  loop.noise().gps_velocity_offset_m_s.x() = 3;
  loop.run(4);
  EXPECT_FALSE(loop.arm());
  loop.run(0.1);
  EXPECT_TRUE(loop.said("GPS velocity contradicts position"));
}

TEST_F(FailsafeFlight, WithAStuckGyroTheRotorsStop) {
  hover();
  loop_.gyro_stuck = true;
  EXPECT_TRUE(loop_.run_until([&] { return !loop_.fcu().status().armed; }, 1));
  EXPECT_TRUE(loop_.said("Gyro stuck"));
}

TEST(Arming, IsRefusedWithAStuckAccelerometer) {
  ClosedLoop loop{LoopOptions{}};
  ASSERT_TRUE(loop.run_until([&] { return loop.fcu().status().estimator_ready; }, 20));
  loop.accel_stuck = true;
  loop.run(1);
  EXPECT_FALSE(loop.arm());
  loop.run(0.1);
  EXPECT_TRUE(loop.said("no accelerometer and gyro data"));
}

TEST(TakeOff, ThatDoesNotClimbIsGivenUp) {
  ClosedLoop loop{LoopOptions{}};
  ASSERT_TRUE(loop.run_until([&] { return loop.fcu().status().estimator_ready; }, 20));
  for (int rotor = 0; rotor < 4; ++rotor) loop.multirotor().weaken_rotor(rotor, 0.3);
  ASSERT_TRUE(loop.arm());
  ASSERT_TRUE(loop.take_off(2.5));
  EXPECT_TRUE(loop.run_until([&] { return !loop.fcu().status().armed; }, 7));
  EXPECT_TRUE(loop.said("Take-off given up: no climb"));
}

TEST_F(FailsafeFlight, WithoutBarometerItHoldsHeightByGps) {
  hover();
  loop_.baro_on = false;
  loop_.run(10);
  EXPECT_TRUE(loop_.said("Barometer lost"));
  EXPECT_EQ(loop_.fcu().status().mode, FlightMode::kHold);
  EXPECT_NEAR(loop_.truth().p_N.z(), -2.5, 0.5);
}

TEST_F(FailsafeFlight, WithoutCompassItHoldsHeadingByGyro) {
  hover();
  loop_.mag_on = false;
  loop_.run(10);
  EXPECT_TRUE(loop_.said("Compass lost"));
  EXPECT_NEAR(loop_.yaw(), 0, 0.1);
}

TEST_F(FailsafeFlight, WithoutGyroAndAccelerometerTheRotorsStop) {
  hover();
  loop_.imu_on = false;
  EXPECT_TRUE(loop_.run_until([&] { return !loop_.fcu().status().armed; }, 1));
  EXPECT_TRUE(loop_.said("Gyro and accelerometer lost"));
  EXPECT_EQ(loop_.fcu().status().mode, FlightMode::kTermination);
}

TEST_F(FailsafeFlight, LosingTheGroundStationReturnsWhenToldTo) {
  ASSERT_TRUE(loop_.fcu().set_param("NAV_DLL_ACT", 2));
  Heartbeat beat;
  beat.type = MavType::kGcs;
  loop_.send(beat);
  hover();
  loop_.send(beat);
  EXPECT_TRUE(reaches(FlightMode::kReturn, 12));
  EXPECT_TRUE(loop_.said("Ground station lost"));
}

TEST_F(FailsafeFlight, LosingThePilotReturns) {
  hover();
  ManualControl sticks;
  sticks.target = 1;
  sticks.z = 500;
  loop_.send(sticks);
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 3, 0}), MavResult::kAccepted);
  EXPECT_TRUE(reaches(FlightMode::kReturn, 3));
  EXPECT_TRUE(loop_.said("Manual control lost"));
}

TEST_F(FailsafeFlight, LosingTheCompanionHolds) {
  hover();
  SetPositionTargetLocalNed target;
  target.target_system = 1;
  target.coordinate_frame = MavFrame::kLocalNed;
  target.z = -2.5F;
  loop_.send(target);
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kAccepted);
  EXPECT_TRUE(reaches(FlightMode::kHold, 3));
  EXPECT_TRUE(loop_.said("Offboard setpoints lost"));
}

TEST_F(FailsafeFlight, ACriticalBatteryReturnsAndAnEmptyOneLands) {
  ASSERT_TRUE(loop_.fcu().set_param("SIM_BAT_MIN_PCT", 0));
  ASSERT_TRUE(loop_.fcu().set_param("SIM_BAT_DRAIN", 200));
  hover();
  ASSERT_TRUE(loop_.fcu().set_param("SIM_BAT_DRAIN", 20));
  EXPECT_TRUE(reaches(FlightMode::kReturn, 30));
  EXPECT_TRUE(loop_.said("Low battery"));
  EXPECT_TRUE(reaches(FlightMode::kLand, 10));
  EXPECT_TRUE(lands());
}

/// A pack of 12 V.
BatteryStatus measured(int remaining_percent) {
  BatteryStatus m;
  m.voltages.fill(0xFFFF);
  m.voltages[0] = 12'000;
  m.current_battery = 4'250;
  m.current_consumed = 77;
  m.battery_remaining = static_cast<std::int8_t>(remaining_percent);
  return m;
}

TEST_F(FailsafeFlight, ABatteryThatTheSimulatorMeasuresTakesThePlaceOfTheOneMadeUp) {
  constexpr mav::Source kSimulator{1, 200};
  hover();
  loop_.send(measured(50), kSimulator);
  loop_.run(2.5);
  EXPECT_EQ(loop_.received<SysStatus>().back().voltage_battery, 12'000);
  EXPECT_EQ(loop_.received<SysStatus>().back().current_battery, 4'250);
  EXPECT_EQ(loop_.received<SysStatus>().back().battery_remaining, 50);
  const auto told = loop_.received<BatteryStatus>();
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.back().voltages[0], 12'000);
  EXPECT_EQ(told.back().voltages[1], 0xFFFF);
  EXPECT_EQ(told.back().current_consumed, 77);
  EXPECT_EQ(told.back().charge_state, MavBatteryChargeState::kOk);

  loop_.send(measured(14), kSimulator);
  loop_.run(1);
  EXPECT_TRUE(loop_.said("Low battery"));
  EXPECT_EQ(loop_.fcu().status().mode, FlightMode::kHold);
  loop_.send(measured(6), kSimulator);
  EXPECT_TRUE(reaches(FlightMode::kReturn, 1));
  loop_.send(measured(4), kSimulator);
  EXPECT_TRUE(reaches(FlightMode::kLand, 1));
}

TEST_F(FailsafeFlight, ABatteryThatFallsSilentIsUnknownUntilItIsHeardAgain) {
  constexpr mav::Source kSimulator{1, 200};
  hover();
  loop_.send(measured(50), kSimulator);
  loop_.run(4);
  EXPECT_EQ(loop_.received<SysStatus>().back().battery_remaining, 50);
  EXPECT_FALSE(loop_.said("Battery unknown: no data"));
  loop_.run(4);
  EXPECT_TRUE(loop_.said("Battery unknown: no data"));
  const SysStatus unknown = loop_.received<SysStatus>().back();
  EXPECT_EQ(unknown.battery_remaining, -1);
  EXPECT_EQ(unknown.voltage_battery, 0xFFFF);
  EXPECT_EQ(unknown.onboard_control_sensors_health & MavSysStatusSensor::kBattery,
            MavSysStatusSensor{});
  EXPECT_EQ(loop_.received<BatteryStatus>().back().battery_remaining, -1);
  EXPECT_EQ(loop_.received<BatteryStatus>().back().charge_state, MavBatteryChargeState::kUndefined);
  EXPECT_EQ(loop_.fcu().status().mode, FlightMode::kHold) << "a warning, nothing more";

  loop_.send(measured(6), kSimulator);
  EXPECT_TRUE(reaches(FlightMode::kReturn, 1));
}

TEST_F(FailsafeFlight, ABatteryThatSaysMoreThanFullIsFull) {
  hover();
  loop_.send(measured(127), {1, 200});
  loop_.run(2.5);
  EXPECT_EQ(loop_.received<SysStatus>().back().battery_remaining, 100);
}

TEST_F(FailsafeFlight, NobodyElsesBatteryCounts) {
  hover();
  BatteryStatus second = measured(1);
  second.id = 1;
  BatteryStatus unknown = measured(-1);
  BatteryStatus without_voltage = measured(1);
  without_voltage.voltages.fill(0xFFFF);
  loop_.send(measured(1));            // a ground station's
  loop_.send(measured(1), {2, 200});  // another vehicle's
  loop_.send(measured(1), {1, 1});    // its own, come back
  for (const BatteryStatus& m : {second, unknown, without_voltage}) loop_.send(m, {1, 200});
  loop_.run(2);
  EXPECT_EQ(loop_.fcu().status().mode, FlightMode::kHold);
  EXPECT_GT(loop_.received<SysStatus>().back().battery_remaining, 80);
}

TEST_F(FailsafeFlight, TiltedTooFarTheRotorsStop) {
  ASSERT_TRUE(loop_.fly_to_hover(20));    // room to fall
  loop_.multirotor().weaken_rotor(0, 0);  // both rotors of the right side
  loop_.multirotor().weaken_rotor(1, 0);
  EXPECT_TRUE(loop_.run_until([&] { return !loop_.fcu().status().armed; }, 10));
  EXPECT_TRUE(loop_.said("tilt too large"));
  EXPECT_EQ(loop_.command(MavCmd::kComponentArmDisarm, {1}), MavResult::kTemporarilyRejected);
}

// Arming checks.

struct MissingSensor {
  const char* name;
  bool ClosedLoop::*sensor;
  const char* reason;
};

class ArmingWithout : public testing::TestWithParam<MissingSensor> {};

TEST_P(ArmingWithout, IsRefusedWithTheReason) {
  ClosedLoop loop{LoopOptions{}};
  loop.*GetParam().sensor = false;
  loop.run(8);
  EXPECT_FALSE(loop.arm());
  loop.run(0.1);
  EXPECT_TRUE(loop.said(GetParam().reason));
}

INSTANTIATE_TEST_SUITE_P(
    Sensors, ArmingWithout,
    testing::Values(MissingSensor{"Imu", &ClosedLoop::imu_on, "no accelerometer and gyro data"},
                    MissingSensor{"Mag", &ClosedLoop::mag_on, "no compass data"},
                    MissingSensor{"Baro", &ClosedLoop::baro_on, "no barometer data"},
                    MissingSensor{"Gps", &ClosedLoop::gps_on, "no GPS data"}),
    [](const auto& test) { return test.param.name; });

TEST(Arming, IsForcedByTheMagicNumber) {
  ClosedLoop loop{LoopOptions{}};
  loop.gps_on = false;
  loop.run(4);
  EXPECT_FALSE(loop.arm());
  EXPECT_EQ(loop.command(MavCmd::kComponentArmDisarm, {1, 21196}), MavResult::kAccepted);
}

TEST(Arming, EndsByItselfWithoutATakeOff) {
  ClosedLoop loop{LoopOptions{}};
  ASSERT_TRUE(loop.run_until([&] { return loop.fcu().status().estimator_ready; }, 20));
  ASSERT_TRUE(loop.arm());
  loop.run(9);
  EXPECT_TRUE(loop.fcu().status().armed);
  loop.run(2);
  EXPECT_FALSE(loop.fcu().status().armed);
}

TEST(LandDetector, ThrustThatStaysHighAgainstTheSetpointIsOfTheGroundToo) {
  constexpr double kStep_s = 0.0025;
  LandDetector detector;
  LandDetector::Input held{.thrust = {.given = 0.9, .wanted = 0.3}, .descending = true};
  const auto stage_after = [&](double seconds) {
    LandDetector::Stage stage{};
    for (double t = 0; t < seconds; t += kStep_s) stage = detector.update(held, kStep_s);
    return stage;
  };
  EXPECT_EQ(stage_after(0.9), LandDetector::Stage::kAir);
  EXPECT_EQ(stage_after(0.6), LandDetector::Stage::kContact);
  held.vertical_speed_m_s = 0.5;
  EXPECT_EQ(stage_after(0.01), LandDetector::Stage::kAir) << "without the thrust it fell";
  held.vertical_speed_m_s = 0;
  EXPECT_EQ(stage_after(0.9), LandDetector::Stage::kAir);
  held.thrust.wanted = 0.9;
  EXPECT_EQ(stage_after(5), LandDetector::Stage::kAir) << "what it wants holds it up";
}

TEST(Arming, IsNotTakenAwayInTheAirWithoutForce) {
  ClosedLoop loop{LoopOptions{}};
  ASSERT_TRUE(loop.fly_to_hover(2.5));
  EXPECT_EQ(loop.command(MavCmd::kComponentArmDisarm, {0}), MavResult::kTemporarilyRejected);
  EXPECT_TRUE(loop.fcu().status().armed);
  EXPECT_EQ(loop.command(MavCmd::kComponentArmDisarm, {0, 21196}), MavResult::kAccepted);
  EXPECT_FALSE(loop.fcu().status().armed);
}

}  // namespace
}  // namespace cas::fcu
