// SPDX-License-Identifier: BSD-3-Clause
// One line of a scenario, `sensors: NAME`, chooses the simulator's sensors and the estimator's
// model of them.
#include <gmock/gmock.h>

#include "base/config/install_paths.hpp"
#include "base/config/vehicle.hpp"
#include "fcu/core/fcu_config.hpp"
#include "fcu/estimation/sensor_figures.hpp"
#include "hils/programs/composition.hpp"
#include "libsim/core/load/sim_config.hpp"
#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

using test::Flight;
using testing::HasSubstr;

void replace(std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
}

/// The shipped hover with a shorter hold and `lines` at its end.
Scenario short_hover(const std::string& lines) {
  std::string text = test::content(cas::test::source_dir() + "/config/scenarios/hover.yaml");
  replace(text, "../vehicles", cas::test::source_dir() + "/config/vehicles");
  replace(text, "duration_s: 30", "duration_s: 8");
  replace(text, "altitude_m: 2.5", "altitude_m: 10");  // cheap heights wander by metres
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("hover" + std::to_string(::getpid()) + ".yaml");
  std::ofstream(file) << text << lines << '\n';
  const Scenario scenario = Scenario::load(file);
  std::filesystem::remove(file);
  return scenario;
}

std::string simulator_text(const RunRequest& request) {
  return simulator_config(request, Transport::kBus,
                          RunPaths::of(request.scenario, request.out, request.out));
}

double horizontal_rms_m(const Flight& flight) {
  const auto& rms = flight.figures().rms;
  return rms ? std::hypot(rms->x_m, rms->y_m) : 1e9;
}

class SensorSet : public testing::TestWithParam<const char*> {};

TEST_P(SensorSet, FliesHoverFromOneLineOfYaml) {
  const std::string name = GetParam();
  Scenario scenario = short_hover("sensors: " + name);
  scenario.limits = {};
  scenario.limits.lost = 0;
  const Flight flight(scenario, 1, name);
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
  EXPECT_LT(horizontal_rms_m(flight), 2) << flight.text();  // the GPS of low_cost wanders as far
}

TEST_P(SensorSet, IsTheSameToSimulatorAndEstimator) {
  const std::string name = GetParam();
  const RunRequest request{.scenario = short_hover("sensors: " + name), .out = "unused"};
  const auto fcu = fcu::FcuConfig::parse(base::ConfigNode::parse(fcu_config(request), "fcu.yaml"));
  const auto sim =
      sim::SimConfig::parse(base::ConfigNode::parse(simulator_text(request), "hilsim.yaml"));
  const base::ConfigNode set =
      base::ConfigNode::load(base::find_config("sensors/" + name + ".yaml"));
  for (const auto& plugin : sim.vehicles.at(0).plugins) {
    const auto expected = set.find(plugin.plugin);
    if (!expected) continue;
    for (const auto& [key, value] : expected->entries()) {
      const bool is_the_scenarios = key == "rate_hz";
      if (is_the_scenarios) continue;
      EXPECT_EQ(plugin.params.at(key).dump(), value.dump()) << plugin.plugin << '.' << key;
      EXPECT_EQ(fcu.sensors.at(plugin.plugin).at(key).dump(), value.dump())
          << plugin.plugin << '.' << key;
    }
  }
  EXPECT_DOUBLE_EQ(fcu.sensors.at("imu").require<double>("rate_hz"), 500);
}

INSTANTIATE_TEST_SUITE_P(All, SensorSet,
                         testing::Values("table1", "gazebo_classic", "rotors_adis16448",
                                         "airsim_mpu6000", "jmavsim", "pixhawk", "pixhawk_icm42605",
                                         "rtk", "low_cost", "ideal"),
                         [](const auto& test) { return std::string(test.param); });

TEST(SensorSets, AllThatAreShippedAreFlown) {
  std::size_t shipped = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(cas::test::source_dir() + "/config/sensors")) {
    shipped += entry.path().extension() == ".yaml" ? 1 : 0;
  }
  EXPECT_EQ(shipped, 10U);
}

TEST(SensorSets, BetterSensorsHoldThePlaceBetter) {
  const Flight rtk(short_hover("sensors: rtk"), 1, "rtk_set");
  const Flight low_cost(short_hover("sensors: low_cost"), 1, "low_cost_set");
  EXPECT_LT(4 * horizontal_rms_m(rtk), horizontal_rms_m(low_cost)) << rtk.text() << low_cost.text();
}

TEST(SensorSets, TakeSingleKeysOverThePreset) {
  const Scenario scenario =
      short_hover("sensors: {preset: rtk, gps: {delay_s: 0.3}, barometer: {stddev_pa: 7}}");
  const RunRequest request{.scenario = scenario, .out = "unused"};
  const auto fcu = fcu::FcuConfig::parse(base::ConfigNode::parse(fcu_config(request), "fcu.yaml"));
  EXPECT_DOUBLE_EQ(fcu::sensor_figures(fcu.sensors).params.gps_delay_s, 0.3);
  EXPECT_DOUBLE_EQ(fcu.sensors.at("barometer").require<double>("stddev_pa"), 7);
  EXPECT_DOUBLE_EQ(fcu.sensors.at("gps").require<double>("rate_hz"), 5);
  EXPECT_EQ(fcu.sensors.at("imu").at("accel_range_m_s2").dump(),
            base::ConfigNode::load(base::find_config("sensors/rtk.yaml"))
                .at("imu")
                .at("accel_range_m_s2")
                .dump());
}

TEST(SensorSets, ThatAreNotThereAreRefused) {
  EXPECT_THROW(short_hover("sensors: atomic"), base::ConfigError);
}

TEST(SensorSets, RefuseABlockForAPluginThatIsNotThere) {
  const std::string said =
      cas::test::refusal([] { short_hover("sensors: {barometre: {stddev_pa: 7}}"); });
  EXPECT_THAT(said, HasSubstr("sensors.barometre: the vehicle has no plugin 'barometre'"));
}

}  // namespace
}  // namespace cas::hils
