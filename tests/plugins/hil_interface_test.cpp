// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/hil_interface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "plugins/mavlink_interface/hil_conversion.hpp"
#include "tests/plugins/recording_port.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using std::chrono::milliseconds;
using test::at_ms;
using test::controls_for;
using test::RecordingPort;
using test::updated;

HilInterfaceParams interface_params() {
  return {.scales = {.u1_max_n = 20, .u2_max_nm = 2, .u3_max_nm = 2, .u4_max_nm = 1},
          .actuator_timeout = milliseconds(500)};
}

ImuSample imu_at(int ms) { return {.time = at_ms(ms)}; }

GpsSample fix_at(int ms) {
  GpsSample sample;
  sample.time = at_ms(ms);
  return sample;
}

class HilInterfaceTest : public testing::Test {
 protected:
  /// The IMU has one, and it is sent.
  void sample(int ms) {
    interface.on_imu(imu_at(ms));
    interface.flush(at_ms(ms));
  }

  RecordingPort port;
  HilInterface interface = HilInterface(interface_params(), port, nullptr);
};

TEST_F(HilInterfaceTest, FlagsOnlyWhatIsNew) {
  interface.on_imu(imu_at(2));
  interface.on_magnetometer({at_ms(2), {0.2, 0, -0.4}});
  interface.on_barometer({at_ms(2), 95600, 12});
  interface.flush(at_ms(2));
  sample(4);
  ASSERT_EQ(port.sensors.size(), 2U);
  EXPECT_EQ(updated(port.sensors[0]), 0x1BFFU);
  EXPECT_EQ(updated(port.sensors[1]), 0x003FU);
  EXPECT_FLOAT_EQ(port.sensors[1].abs_pressure, 956);  // repeats the last value, not flagged
  EXPECT_EQ(port.sensors[1].time_usec, 4000U);
}

TEST_F(HilInterfaceTest, APitotTubeFillsDiffPressureWhenItHasASample) {
  interface.on_imu(imu_at(2));
  interface.on_airspeed({at_ms(2), 250});
  interface.flush(at_ms(2));
  sample(4);
  ASSERT_EQ(port.sensors.size(), 2U);
  EXPECT_EQ(updated(port.sensors[0]), 0x043FU);
  EXPECT_FLOAT_EQ(port.sensors[0].diff_pressure, 2.5F);  // hPa
  EXPECT_EQ(updated(port.sensors[1]), 0x003FU);
}

TEST_F(HilInterfaceTest, EachSensorOfAKindHasAnIdAndOnlyItsOwnBits) {
  interface.on_imu(imu_at(2));
  interface.on_imu(imu_at(2), 1);
  interface.on_magnetometer({at_ms(2), {0.2, 0, -0.4}}, 1);
  interface.on_barometer({at_ms(2), 95600, 12}, 2);
  interface.on_gps(fix_at(1));
  interface.on_gps(fix_at(2), 1);
  interface.flush(at_ms(2));
  // The clock comes last, so that its answer knows the others.
  ASSERT_EQ(port.sensors.size(), 3U);
  EXPECT_EQ(port.sensors[0].id, 1);
  EXPECT_EQ(updated(port.sensors[0]), 0x01FFU);
  EXPECT_EQ(port.sensors[1].id, 2);
  EXPECT_EQ(updated(port.sensors[1]), 0x1A00U);
  EXPECT_EQ(port.sensors[2].id, 0);
  EXPECT_EQ(updated(port.sensors[2]), 0x003FU);
  for (const mv::HilSensor& sensor : port.sensors) EXPECT_EQ(sensor.time_usec, 2000U);
  ASSERT_EQ(port.fixes.size(), 2U);
  EXPECT_EQ(port.fixes[0].id, 0);
  EXPECT_EQ(port.fixes[1].id, 1);
}

TEST_F(HilInterfaceTest, TheClockGoesOnWithoutTheFirstImuWhileAnotherSpeaks) {
  interface.on_imu(imu_at(4), 1);
  interface.flush(at_ms(4));
  ASSERT_EQ(port.sensors.size(), 2U);
  EXPECT_EQ(port.sensors[1].id, 0);
  EXPECT_EQ(port.sensors[1].time_usec, 4000U);
  EXPECT_EQ(updated(port.sensors[1]), 0U);
  EXPECT_FALSE(interface.answered());
  port.put(controls_for(4));
  interface.receive();
  EXPECT_TRUE(interface.answered());
  EXPECT_TRUE(interface.settled());
}

TEST(HilInterface, Px4IsNotWaitedForUntilItHasChosenAnotherImu) {
  HilInterfaceParams params = interface_params();
  params.joins_by_answering = true;
  RecordingPort port;
  HilInterface interface(params, port, nullptr);
  const auto step = [&](int ms, bool first_speaks) {
    if (first_speaks) interface.on_imu(imu_at(ms));
    interface.on_imu(imu_at(ms), 1);
    interface.flush(at_ms(ms));
  };
  const auto answer = [&](int ms) {
    port.put(controls_for(ms));
    interface.receive();
  };
  step(4, true);
  answer(4);
  ASSERT_TRUE(interface.in_step());
  step(8, false);
  EXPECT_FALSE(interface.in_step());
  step(12, false);
  EXPECT_FALSE(interface.in_step());
  answer(12);  // by what it still had of the first
  EXPECT_FALSE(interface.in_step());
  step(2008, false);
  answer(2008);  // it flies by the second one now
  EXPECT_TRUE(interface.in_step());
  step(2012, false);
  EXPECT_TRUE(interface.in_step());
  EXPECT_FALSE(interface.answered());
  interface.give_up();  // it does not, after all
  EXPECT_FALSE(interface.in_step());
}

TEST(HilInterface, Px4GetsTheClockBeforeTheSensorsThatItStampsByIt) {
  HilInterfaceParams params = interface_params();
  params.joins_by_answering = true;
  RecordingPort port;
  HilInterface interface(params, port, nullptr);
  interface.on_imu(imu_at(4), 1);
  interface.on_imu(imu_at(4));
  interface.flush(at_ms(4));
  ASSERT_EQ(port.sensors.size(), 2U);
  EXPECT_EQ(port.sensors[0].id, 0);
  EXPECT_EQ(port.sensors[1].id, 1);
}

TEST(TruthOnRequest, ComesAtItsRateBeforeASensorPacket) {
  struct TruthCase {
    const char* name;
    bool in_software;
    float interval_us;
    int expected;  // packets in a second of 250 HIL_SENSORs
  };
  const TruthCase rows[] = {{"OfPx4", true, 5000, 200},
                            {"Usual", true, 0, 50},
                            {"Never", true, -1, 0},
                            {"OncePerSample", true, 1, 250},
                            {"NotANumber", true, std::numeric_limits<float>::quiet_NaN(), 0},
                            {"NotInHitl", false, 5000, 0}};
  for (const auto& asked : rows) {
    SCOPED_TRACE(asked.name);
    RecordingPort port;
    HilInterfaceParams params = interface_params();
    params.joins_by_answering = asked.in_software;
    HilInterface interface(params, port, nullptr);
    mv::CommandLong request{.command = mv::MavCmd::kSetMessageInterval,
                            .param1 = mv::HilStateQuaternion::kId,
                            .param2 = asked.interval_us};
    port.put(request);
    interface.receive();
    for (int ms = 1; ms <= 1000; ++ms) {
      if (ms % 4 == 0) interface.on_imu(imu_at(ms));
      if (interface.truth_due(at_ms(ms))) interface.on_truth({});
      interface.flush(at_ms(ms));
    }
    EXPECT_EQ(std::ranges::count(port.ids, mv::HilStateQuaternion::kId), asked.expected);
    for (std::size_t i = 0; i < port.ids.size(); ++i) {
      if (port.ids[i] != mv::HilStateQuaternion::kId) continue;
      EXPECT_EQ(port.ids.at(i + 1), mv::HilSensor::kId);
    }
  }
}

TEST_F(HilInterfaceTest, SendsEachSampleOfTheBatteryOnceAheadOfTheSensors) {
  interface.on_imu(imu_at(2));
  interface.on_battery({.time = at_ms(2), .voltage_v = 12});
  interface.flush(at_ms(2));
  sample(4);
  EXPECT_EQ(port.ids, (std::vector<std::uint32_t>{mv::Heartbeat::kId, mv::BatteryStatus::kId,
                                                  mv::HilSensor::kId, mv::HilSensor::kId}));
}

TEST_F(HilInterfaceTest, SendsTelemetryOfSpeedControllersByFours) {
  EscSample sample{.time = at_ms(1000), .voltage_v = 14.5};
  sample.omega_rad_s = base::RotorVector::LinSpaced(6, 0, 500);
  sample.current_a = base::RotorVector::LinSpaced(6, 0, 5);
  interface.on_esc(sample);
  interface.flush(at_ms(1000));
  sample.time = at_ms(1100);
  interface.on_esc(sample);
  interface.flush(at_ms(1100));
  const auto status = mv::EscStatus::kId;
  const auto info = mv::EscInfo::kId;
  EXPECT_EQ(port.ids, (std::vector<std::uint32_t>{mv::Heartbeat::kId, status, info, status, info,
                                                  status, status}))
      << "ESC_INFO once a second";

  const mv::EscStatus second = to_esc_status(sample, 4);
  EXPECT_EQ(second.index, 4);
  EXPECT_EQ(second.time_usec, 1'100'000U);
  EXPECT_EQ(second.rpm, (std::array<std::int32_t, 4>{3820, 4775, 0, 0}));  // 400 and 500 rad/s
  EXPECT_EQ(second.current, (std::array<float, 4>{4, 5, 0, 0}));
  EXPECT_EQ(second.voltage, (std::array<float, 4>{14.5F, 14.5F, 0, 0}));
  const mv::EscInfo about = to_esc_info(sample, 4, 7);
  EXPECT_EQ(about.count, 6);
  EXPECT_EQ(about.info, 0b11);
  EXPECT_EQ(about.counter, 7);
}

TEST_F(HilInterfaceTest, SendsNothingWithoutANewSample) {
  interface.flush(at_ms(1));
  interface.flush(at_ms(2));
  EXPECT_EQ(port.ids, std::vector<std::uint32_t>{mv::Heartbeat::kId});
}

TEST_F(HilInterfaceTest, SendsTheFixBeforeTheSensorsOfTheSameMoment) {
  interface.on_imu(imu_at(200));
  interface.on_gps(fix_at(200));
  interface.flush(at_ms(200));
  EXPECT_EQ(port.ids, (std::vector<std::uint32_t>{0, 113, 107}));
  EXPECT_EQ(port.source, (mav::Source{1, 200}));
}

TEST_F(HilInterfaceTest, BeatsOncePerSecond) {
  for (int ms = 1; ms <= 10000; ++ms) interface.flush(at_ms(ms));
  EXPECT_EQ(interface.sent().of(mv::Heartbeat::kId), 11U);  // one at once, then each second
}

TEST_F(HilInterfaceTest, CountsOnlyWhatThePortTook) {
  port.refuses = true;
  sample(2);
  EXPECT_EQ(interface.sent().of(mv::HilSensor::kId), 0U);
}

TEST_F(HilInterfaceTest, TakesTheNewestCommandOnce) {
  port.put(controls_for(2, 0.25F));
  port.put(controls_for(4, 0.5F));
  interface.receive();
  const auto command = interface.take_command(at_ms(5));
  ASSERT_TRUE(command);
  EXPECT_DOUBLE_EQ(command->values[0], 10);
  EXPECT_FALSE(interface.take_command(at_ms(6)));
  EXPECT_EQ(interface.received().of(mv::HilControls::kId), 2U);
}

TEST_F(HilInterfaceTest, TakesActuatorControlsToo) {
  mv::HilActuatorControls outputs;
  outputs.controls[2] = 0.5F;
  outputs.mode = static_cast<decltype(outputs.mode)>(129);
  port.put(outputs);
  interface.receive();
  const auto command = interface.take_command(at_ms(1));
  ASSERT_TRUE(command);
  EXPECT_EQ(command->kind, MotorCommand::Kind::kMotorOutputs);
  EXPECT_TRUE(command->armed);
}

TEST_F(HilInterfaceTest, StopsTheRotorsWhenTheStreamDies) {
  EXPECT_FALSE(interface.take_command(at_ms(10000)));  // never a stream: nothing to lose
  port.put(controls_for(2));
  interface.receive();
  EXPECT_TRUE(interface.take_command(at_ms(10000))->armed);
  EXPECT_FALSE(interface.take_command(at_ms(10499)));
  const auto stop = interface.take_command(at_ms(10500));
  ASSERT_TRUE(stop);
  EXPECT_FALSE(stop->armed);
  EXPECT_TRUE(stop->values.isZero(0.0));
  EXPECT_FALSE(interface.take_command(at_ms(12000)));  // once
  EXPECT_EQ(interface.actuator_timeouts(), 1U);
}

TEST_F(HilInterfaceTest, WaitsForTheAnswersThatAreDue) {
  // 400 Hz on 500 Hz: floor(t * 400) advances at 4, 6, 8, 10, not at 2, 12, ...
  std::vector<int> due;
  for (int ms = 2; ms <= 20; ms += 2) {
    sample(ms);
    if (!interface.answered()) due.push_back(ms);
    port.put(controls_for(ms));
    interface.receive();
    EXPECT_TRUE(interface.answered());
  }
  EXPECT_EQ(due, (std::vector<int>{4, 6, 8, 10, 14, 16, 18, 20}));
}

TEST_F(HilInterfaceTest, IsSettledWhenTheLastPacketSentHasBeenAnswered) {
  EXPECT_TRUE(interface.settled()) << "nothing was sent";
  sample(4);
  EXPECT_FALSE(interface.settled());
  port.put(controls_for(4));
  interface.receive();
  EXPECT_TRUE(interface.settled());
  interface.on_gps(fix_at(5));
  interface.flush(at_ms(5));
  EXPECT_FALSE(interface.settled()) << "a fix is not answered";
  sample(6);
  port.put(controls_for(4));
  interface.receive();
  EXPECT_FALSE(interface.settled()) << "an old answer";
  port.put(controls_for(6));
  interface.receive();
  EXPECT_TRUE(interface.settled());
}

TEST_F(HilInterfaceTest, AnAnswerToWhatWasNeverSentIsNone) {
  sample(4);
  port.put(controls_for(900));
  interface.receive();
  EXPECT_FALSE(interface.answered());
}

TEST(HilInterface, KeepsALedgerOfHilPackets) {
  RecordingPort port;
  base::PacketLedger ledger(16);
  HilInterface interface(interface_params(), port, &ledger);
  interface.on_imu(imu_at(2));
  interface.on_gps(fix_at(1));
  interface.flush(at_ms(2));
  port.put(controls_for(2));
  interface.receive();
  ASSERT_EQ(ledger.entries().size(), 3U);  // no heartbeat
  EXPECT_EQ(ledger.entries()[0].message_id, mv::HilGps::kId);
  EXPECT_EQ(ledger.entries()[0].time_usec, 1000U);
  EXPECT_EQ(ledger.entries()[1].message_id, mv::HilSensor::kId);
  EXPECT_EQ(ledger.entries()[2].direction, base::LedgerEntry::Direction::kReceived);
  EXPECT_EQ(ledger.entries()[2].time_usec, 2000U);
  EXPECT_EQ(ledger.entries()[2].at_ns, 100'000'000'000);
}

TEST_F(HilInterfaceTest, CountsDamageAndGapsInTheSequence) {
  port.put(controls_for(2));
  port.put(controls_for(4));
  port.put(controls_for(6));
  port.in[1][20] ^= 0xFF;
  interface.receive();
  EXPECT_EQ(interface.received().of(mv::HilControls::kId), 2U);
  const nlohmann::ordered_json figures = interface.figures();
  EXPECT_EQ(figures["crc_errors"], 1);
  EXPECT_EQ(figures["sequence_gaps"], 1);
  EXPECT_EQ(figures["received"]["HIL_CONTROLS"], 2);
}

/// Heights rise by 100 m a degree to the north and 10 m to the east.
double slope_m(double lat_deg, double lon_deg) { return 100 * lat_deg + 10 * lon_deg; }

TEST_F(HilInterfaceTest, AnswersARequestForTerrainGridByGrid) {
  std::vector<mv::TerrainData> grids;
  std::vector<int> at;
  const auto step = [&](int ms) {
    interface.receive();
    port.packets.clear();
    interface.send_terrain(at_ms(ms), slope_m);
    mav::PacketParser parser(mv::table());
    for (const auto& packet : port.packets) {
      parser.feed(packet, [&](const mav::PacketView& view) {
        grids.push_back(mav::decode<mv::TerrainData>(view).value());
        at.push_back(ms);
      });
    }
  };
  mv::TerrainRequest request;
  request.lat = 600'000'000;  // 60 degrees north, where a degree of longitude is half as long
  request.lon = 1'799'000'000;
  request.grid_spacing = 1000;
  request.mask = 1ULL << 0U | 1ULL << 3U | 1ULL << 17U | 1ULL << 60U;  // no 60th grid
  port.put(request);
  for (int ms = 0; ms < 200; ++ms) step(ms);
  ASSERT_EQ(grids.size(), 3U);
  EXPECT_EQ(at, (std::vector{0, 20, 40}));
  const int bits[3] = {0, 3, 17};
  for (std::size_t n = 0; n < 3; ++n) {
    const mv::TerrainData& grid = grids[n];
    EXPECT_EQ(grid.gridbit, bits[n]);
    EXPECT_EQ(grid.lat, request.lat);
    EXPECT_EQ(grid.lon, request.lon);
    EXPECT_EQ(grid.grid_spacing, 1000);
    for (int i = 0; i < 16; ++i) {
      const double north_km = bits[n] / 8 * 4 + i / 4;
      const double east_km = bits[n] % 8 * 4 + i % 4;
      const double lat = 60 + north_km / 111.3188;
      const double lon = 179.9 + east_km / 111.3188 / std::cos(lat * M_PI / 180);
      constexpr double kRounding_m = 0.6;  // whole metres, and the latitude of the scale
      EXPECT_NEAR(grid.data[static_cast<std::size_t>(i)], slope_m(lat, lon > 180 ? lon - 360 : lon),
                  kRounding_m)
          << n << " " << i;
    }
  }
}

}  // namespace
}  // namespace cas::sim
