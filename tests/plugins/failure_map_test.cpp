// SPDX-License-Identifier: BSD-3-Clause
// MAV_CMD_INJECT_FAILURE, from the wire to plugin fault.
#include "plugins/mavlink_interface/failure_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "plugins/fault/fault_spec.hpp"
#include "plugins/mavlink_interface/bus_port.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/recording_port.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using mav::services::FailureOrder;
using std::chrono::milliseconds;
using Unit = mav::services::FailureUnit;
using Type = mav::services::FailureType;
using Refusal = mav::services::FailureRefusal;

constexpr VehicleParts kQuad{
    .sensors = kPartImu | kPartGps | kPartMagnetometer | kPartBarometer | kPartRangefinder,
    .rotors = 4};

VehicleParts with_second(VehiclePart part) {
  VehicleParts parts = kQuad;
  parts.sensors.add(part, 1);
  return parts;
}

TEST(FailureMap, MakesAFailurePhysicalOrRefusesIt) {
  struct MapCase {
    const char* name;
    FailureOrder failure;
    VehicleParts parts;
    std::vector<std::string> orders;  // empty: there is no such physical failure
  };
  const MapCase rows[] = {
      {"GpsOff",
       {Unit::kGps, Type::kOff},
       kQuad,
       {"{end: 'injected gps'}", "{name: 'injected gps', at_s: 0, drop: gps}"}},
      {"OkEndsAllOfTheUnit", {Unit::kGps, Type::kOk}, kQuad, {"{end: 'injected gps'}"}},
      {"TheFirstIsTheOnlyOne", {Unit::kGps, Type::kOk, 1}, kQuad, {"{end: 'injected gps'}"}},
      {"TheSecondOfTwoGps",
       {Unit::kGps, Type::kOff, 2},
       with_second(kPartGps),
       {"{end: 'injected gps 2'}", "{name: 'injected gps 2', at_s: 0, drop: gps_2}"}},
      {"AllOfTwoImus",
       {Unit::kGyro, Type::kStuck},
       with_second(kPartImu),
       {"{end: 'injected gyro'}",
        "{name: 'injected gyro', at_s: 0, freeze: {sensor: imu, field: angular_rate}}",
        "{end: 'injected gyro 2'}",
        "{name: 'injected gyro 2', at_s: 0, freeze: {sensor: imu_2, field: angular_rate}}"}},
      {"ThereIsNoSecondGps", {Unit::kGps, Type::kOff, 2}, kQuad, {}},
      {"AVehicleWithoutGpsLosesNone", {Unit::kGps, Type::kOff}, {.rotors = 4}, {}},
      {"OneMotor",
       {Unit::kMotor, Type::kOff, 2},
       kQuad,
       {"{end: 'injected motor 2'}",
        "{name: 'injected motor 2', at_s: 0, rotor: {number: 2, stop: true}}"}},
      {"AllMotors",
       {Unit::kMotor, Type::kOk},
       {.rotors = 3},
       {"{end: 'injected motor 1'}", "{end: 'injected motor 2'}", "{end: 'injected motor 3'}"}},
      {"ThereIsNoFifthMotor", {Unit::kMotor, Type::kOff, 5}, kQuad, {}},
      {"NoGyroAloneFallsSilent", {Unit::kGyro, Type::kOff}, kQuad, {}},
      {"NoServos", {Unit::kServo, Type::kOff}, kQuad, {}},
      {"NoTubeNoFailure", {Unit::kAirspeed, Type::kOk}, kQuad, {}},
      {"ATubeIsBlocked",
       {Unit::kAirspeed, Type::kStuck},
       {.sensors = kPartAirspeed, .rotors = 1},
       {"{end: 'injected airspeed'}", "{name: 'injected airspeed', at_s: 0, freeze: airspeed}"}},
      {"NoOdometryNoFailure", {Unit::kVio, Type::kOff}, kQuad, {}},
      {"OdometryIsLate",
       {Unit::kVio, Type::kDelayed},
       {.sensors = kPartOdometry, .rotors = 4},
       {"{end: 'injected vio'}",
        "{name: 'injected vio', at_s: 0, delay: {sensor: odometry, by_s: 0.3}}"}},
      {"AnUnknownUnit", {static_cast<Unit>(42), Type::kOff}, kQuad, {}},
      {"AnUnknownType", {Unit::kGps, static_cast<Type>(99)}, kQuad, {}}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const auto orders = fault_orders(row.failure, row.parts);
    EXPECT_EQ(orders.value_or(std::vector<std::string>{}), row.orders);
    EXPECT_EQ(orders.has_value(), !row.orders.empty());
  }
}

TEST(FailureMapAsAWhole, HasOrdersThatPluginFaultReads) {
  int failures = 0;
  VehicleParts all = kQuad;
  all.sensors.add(kPartOdometry, 0);
  for (int unit = 0; unit < 256; ++unit) {
    for (int type = 1; type < 256; ++type) {
      const auto orders = fault_orders({static_cast<Unit>(unit), static_cast<Type>(type), 1}, all);
      if (!orders) continue;
      ++failures;
      ASSERT_GE(orders->size(), 2U);
      for (std::size_t i = 1; i < orders->size(); ++i) {
        EXPECT_NO_THROW(parse_fault(base::ConfigNode::parse((*orders)[i], "order"), 1))
            << (*orders)[i];
      }
      EXPECT_TRUE(fault_orders({static_cast<Unit>(unit), Type::kOk, 1}, all)) << unit;
    }
  }
  EXPECT_EQ(failures, 45);
}

/// A vehicle with sensors on the bus, whose simulator is sent commands.
class InjectedVehicle : public testing::Test {
 protected:
  void start(const std::string& fault) {
    harness_.add("gps",
                 "{rate_hz: 50, position_stddev_m: 0.3, velocity_stddev_m_s: 0.1, eph_m: 0.4, "
                 "epv_m: 0.3, satellites: 10}");
    harness_.add("imu", "{rate_hz: 500, gyro_stddev_deg_s: 0.1, accel_stddev_m_s2: 0.1}");
    if (!fault.empty()) harness_.add("fault", fault);
    harness_.add("mavlink_interface", "{transport: bus}");
    listening_ = harness_.bus.subscribe<WirePacket>("iris0/wire_out", [&](const WirePacket& p) {
      const mav::PacketView packet = mav::view_packet({p.bytes.data(), p.size});
      if (const auto fix = mav::decode<mv::HilGps>(packet)) {
        ++fixes_;
        southmost_ = std::min(southmost_, fix->lat);
        northmost_ = std::max(northmost_, fix->lat);
      }
      if (const auto ack = mav::decode<mv::CommandAck>(packet)) acks_.push_back(*ack);
    });
    run(milliseconds(100));
  }

  void command(const FailureOrder& failure, float token, mav::Source to = {1, 200}) {
    mv::CommandLong message = mav::services::command_of(failure, to);
    message.param7 = token;
    const auto bytes = encoder_(message);
    WirePacket packet{.size = bytes.size()};
    std::ranges::copy(bytes, packet.bytes.begin());
    wire_in_.publish(packet);
  }

  void run(base::Duration time) { harness_.run(time); }

  /// Fixes in the next 200 ms, of ten; the first step of it may still be as before.
  int fixes() {
    run(milliseconds(20));
    fixes_ = 0;
    run(milliseconds(200));
    return fixes_;
  }

  test::PluginHarness harness_;
  Publisher<WirePacket> wire_in_ = harness_.bus.advertise<WirePacket>("iris0/wire_in");
  Subscription listening_;
  mav::Encoder encoder_{{254, 190}};
  int fixes_ = 0;
  std::int32_t southmost_ = std::numeric_limits<std::int32_t>::max();
  std::int32_t northmost_ = std::numeric_limits<std::int32_t>::min();
  std::vector<mv::CommandAck> acks_;
};

TEST_F(InjectedVehicle, LosesItsGpsAndGetsItBack) {
  start("{by_hand: true}");
  EXPECT_EQ(fixes(), 10);
  command({Unit::kGps, Type::kOff}, 7);
  EXPECT_EQ(fixes(), 0);
  ASSERT_EQ(acks_.size(), 1U);
  EXPECT_EQ(acks_[0].command, mv::MavCmd::kInjectFailure);
  EXPECT_EQ(acks_[0].result, mv::MavResult::kAccepted);
  EXPECT_EQ(acks_[0].result_param2, 7);
  EXPECT_EQ(acks_[0].target_system, 254);
  EXPECT_EQ(acks_[0].target_component, 190);
  command({Unit::kGps, Type::kSlow}, 8);  // takes the place of the first
  EXPECT_EQ(fixes(), 1);
  command({Unit::kGps, Type::kOk}, 9);
  EXPECT_EQ(fixes(), 10);
  EXPECT_EQ(acks_.back().result, mv::MavResult::kAccepted);
}

TEST_F(InjectedVehicle, SaysWhatItHasNoPhysicsFor) {
  start("{by_hand: true}");
  command({Unit::kServo, Type::kOff}, 1);
  command({Unit::kBaro, Type::kOff}, 2);  // it has none
  EXPECT_EQ(fixes(), 10);
  ASSERT_EQ(acks_.size(), 2U);
  for (const mv::CommandAck& ack : acks_) EXPECT_EQ(ack.result, mv::MavResult::kUnsupported);
  EXPECT_EQ(acks_[0].progress, static_cast<std::uint8_t>(Refusal::kUnit));
  EXPECT_EQ(acks_[1].progress, static_cast<std::uint8_t>(Refusal::kPart));
}

TEST(FailureRefusal, SaysWhatIsMissing) {
  EXPECT_EQ(why_no_orders({Unit::kServo, Type::kOff}, kQuad), Refusal::kUnit);
  EXPECT_EQ(why_no_orders({Unit::kServo, Type::kOk}, kQuad), Refusal::kUnit);
  EXPECT_EQ(why_no_orders({Unit::kGyro, Type::kOff}, kQuad), Refusal::kType);
  EXPECT_EQ(why_no_orders({Unit::kGps, Type::kOff, 2}, {.rotors = 4}), Refusal::kPart);
  EXPECT_EQ(why_no_orders({Unit::kMotor, Type::kOff, 5}, kQuad), Refusal::kInstance);
}

TEST_F(InjectedVehicle, TakesNoHalfOfAFailureWhereThereIsRoomForHalf) {
  start("{by_hand: true}");
  for (int i = 1; i < 200; ++i) {
    command({Unit::kGps, Type::kSlow}, static_cast<float>(i));
    run(milliseconds(10));
  }
  ASSERT_EQ(acks_.size(), 199U);
  EXPECT_EQ(acks_.back().result, mv::MavResult::kAccepted);
  command({Unit::kGps, Type::kGarbage}, 200);  // of position and velocity
  EXPECT_EQ(fixes(), 10);
  EXPECT_EQ(acks_.back().result, mv::MavResult::kFailed);
  EXPECT_EQ(acks_.back().progress, static_cast<std::uint8_t>(Refusal::kFull));
  EXPECT_LT(northmost_ - southmost_, 10'000) << "100 m, of a noise of 1000 m";
}

TEST_F(InjectedVehicle, LeavesCommandsToOthersAlone) {
  start("{by_hand: true}");
  command({Unit::kGps, Type::kOff}, 1, {1, 1});
  command({Unit::kGps, Type::kOff}, 1, {0, 0});
  EXPECT_EQ(fixes(), 10);
  EXPECT_TRUE(acks_.empty());
}

TEST_F(InjectedVehicle, TakesNoFailureWithoutByHand) {
  start("{faults: [{at_s: 1000, drop: gps}]}");
  command({Unit::kGps, Type::kOff}, 1);
  EXPECT_EQ(fixes(), 10);
  ASSERT_EQ(acks_.size(), 1U);
  EXPECT_EQ(acks_[0].result, mv::MavResult::kUnsupported);
  EXPECT_EQ(acks_[0].progress, static_cast<std::uint8_t>(Refusal::kByHand));
}

}  // namespace
}  // namespace cas::sim
