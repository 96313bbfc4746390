// SPDX-License-Identifier: BSD-3-Clause
// Messages to a flight controller from each shipped sensor set, at rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <vector>

#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/recording_port.hpp"
#include "tests/support/paths.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using test::RecordingPort;
using test::updated;

constexpr std::array kSensors{"imu", "gps", "magnetometer", "barometer", "rangefinder"};
constexpr std::array kSets{"table1",   "gazebo_classic", "rotors_adis16448", "airsim_mpu6000",
                           "jmavsim",  "pixhawk",        "pixhawk_icm42605", "rtk",
                           "low_cost", "ideal"};

/// Ten seconds of `set` on the wire.
void run_set(const std::string& set, base::Duration step, RecordingPort& wire) {
  test::PluginHarness harness(step);
  harness.world.body.p_WB.z() = 1;
  const base::ConfigNode figures =
      base::ConfigNode::load(cas::test::source_dir() + "/config/sensors/" + set + ".yaml");
  for (const char* sensor : kSensors) harness.add(sensor, figures.at(sensor).dump());
  harness.add("mavlink_interface", "{transport: bus}");
  const auto listening =
      harness.bus.subscribe<WirePacket>("iris0/wire_out", [&](const WirePacket& packet) {
        wire.send({packet.bytes.data(), packet.size});
      });
  harness.run(std::chrono::seconds(10));
}

/// Length of the longest stretch of one value.
template <class Value>
std::size_t longest_run(const std::vector<Value>& values) {
  std::size_t longest = 0;
  std::size_t run = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    run = i > 0 && values[i] == values[i - 1] ? run + 1 : 1;
    longest = std::max(longest, run);
  }
  return longest;
}

class SensorStream : public testing::TestWithParam<const char*> {};

TEST_P(SensorStream, NeverLooksDead) {
  RecordingPort wire;
  run_set(GetParam(), std::chrono::milliseconds(1), wire);
  using Axes = std::array<float, 3>;
  std::vector<Axes> force;
  std::vector<Axes> rate;
  std::vector<Axes> field;
  std::vector<float> pressure;
  for (const mv::HilSensor& s : wire.sensors) {
    force.push_back({s.xacc, s.yacc, s.zacc});
    rate.push_back({s.xgyro, s.ygyro, s.zgyro});
    if ((updated(s) & kUpdatedMag) == kUpdatedMag) field.push_back({s.xmag, s.ymag, s.zmag});
    if ((updated(s) & kUpdatedBaro) == kUpdatedBaro) pressure.push_back(s.abs_pressure);
  }
  // A sensor that rounds may repeat a value by chance; firmware takes 100 alike for dead.
  constexpr std::size_t kByChance = 4;
  EXPECT_LE(longest_run(force), kByChance);
  EXPECT_LE(longest_run(rate), kByChance);
  EXPECT_LE(longest_run(field), kByChance);
  EXPECT_LE(longest_run(pressure), kByChance);
  EXPECT_GE(field.size(), 100U);
  EXPECT_GE(pressure.size(), 100U);
}

TEST_P(SensorStream, CountsAreThoseOfItsRatesAtAnyStep) {
  const base::ConfigNode figures =
      base::ConfigNode::load(cas::test::source_dir() + "/config/sensors/" + GetParam() + ".yaml");
  const auto samples = [&](const char* sensor) {
    return static_cast<std::size_t>(10 * figures.at(sensor).require<double>("rate_hz"));
  };
  for (const int step_us : {500, 1000}) {
    RecordingPort wire;
    run_set(GetParam(), std::chrono::microseconds(step_us), wire);
    const auto with = [&](std::uint32_t bits) {
      return static_cast<std::size_t>(std::ranges::count_if(
          wire.sensors, [bits](const auto& s) { return (updated(s) & bits) == bits; }));
    };
    EXPECT_EQ(wire.sensors.size(), samples("imu")) << step_us;
    EXPECT_EQ(with(kUpdatedMag), samples("magnetometer")) << step_us;
    EXPECT_EQ(with(kUpdatedBaro), samples("barometer")) << step_us;
    EXPECT_EQ(with(~std::uint32_t{0x1BFF}), 0U) << "a bit that means nothing";
    const double delay_s = figures.at("gps").get<double>("delay_s", 0);
    const double gps_hz = figures.at("gps").require<double>("rate_hz");
    EXPECT_EQ(wire.fixes.size(), static_cast<std::size_t>((10 - delay_s) * gps_hz + 1e-6));
  }
}

TEST_P(SensorStream, IsNothingButSensors) {
  RecordingPort wire;
  run_set(GetParam(), std::chrono::milliseconds(1), wire);
  // HEARTBEAT, HIL_SENSOR, HIL_GPS, DISTANCE_SENSOR; HIL_STATE_QUATERNION (115) would lay the truth
  // over the controller's own estimate.
  const std::set<std::uint32_t> ids(wire.ids.begin(), wire.ids.end());
  EXPECT_EQ(ids, (std::set<std::uint32_t>{0, 107, 113, 132}));
}

INSTANTIATE_TEST_SUITE_P(Shipped, SensorStream, testing::ValuesIn(kSets),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace cas::sim
