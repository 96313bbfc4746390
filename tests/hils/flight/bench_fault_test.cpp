// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/bench_fault.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

base::SimTime at_time(base::Duration since_start) { return base::SimTime(since_start); }

ScenarioFaults faults_of(const std::string& text, const VehicleNames& names = only_vehicle()) {
  const auto line = base::ConfigNode::parse("{preset: baud_460800}", "line");
  return parse_scenario_faults(base::ConfigNode::parse(text, "scenario.yaml"), line, names);
}

std::string error_of(const std::string& text) {
  return test::refusal([&] { faults_of(text); });
}

TEST(ScenarioFaults, BelongToTheBenchOrToTheVehicle) {
  const ScenarioFaults faults = faults_of(
      "[{at_s: 1, for_s: 2, unplug: fcu}, {at_s: 3, drop: gps},"
      " {when: altitude > 2, for_s: 1, restart: casd}, {at_s: 1, for_s: 1, flood_hz: 500}]");
  EXPECT_EQ(faults.bench.size(), 3U);
  ASSERT_EQ(faults.vehicle.size(), 1U);
  EXPECT_EQ(faults.vehicle[0].script.require<std::string>("drop"), "gps");
}

TEST(ScenarioFaults, SilenceStarveAndReloadAreTheBenchs) {
  const ScenarioFaults faults = faults_of(
      "[{at_s: 1, for_s: 2, silence: ground},"
      " {at_s: 1, for_s: 2, starve: {p50_us: 100, p99_us: 2000}},"
      " {at_s: 1, for_s: 2, reload: casd}]");
  ASSERT_EQ(faults.bench.size(), 3U);
  EXPECT_TRUE(std::holds_alternative<SilenceFault>(faults.bench[0].kind));
  EXPECT_DOUBLE_EQ(std::get<StarveFault>(faults.bench[1].kind).wake_up.p99_us, 2000);
  EXPECT_TRUE(std::holds_alternative<ReloadFault>(faults.bench[2].kind));
  for (const BenchFault& fault : faults.bench) EXPECT_TRUE(fault.is_everybodys()) << fault.name;
}

TEST(ScenarioFaults, OverrideTheLineOfTheScenario) {
  const ScenarioFaults faults = faults_of("[{at_s: 1, for_s: 2, line: {packet_loss: 0.5}}]");
  const auto& line = std::get<LineFault>(faults.bench.at(0).kind).line;
  EXPECT_DOUBLE_EQ(line.baud, 460800);
  EXPECT_DOUBLE_EQ(line.packet_loss, 0.5);
}

TEST(BadFaults, AreRefusedWithALineAndAReason) {
  struct BadFault {
    const char* text;
    const char* sentence;
  };
  const BadFault rows[] = {{"[{for_s: 1, unplug: fcu}]", "needs at_s or when"},
                           {"[{at_s: 1, unplug: fcu}]", "for_s"},
                           {"[{at_s: 1, for_s: 1, unplug: fcu, flood_hz: 9}]", "second effect"},
                           {"[{when: height_of > 2, for_s: 1, restart: casd}]", "height_of"},
                           {"[{at_s: 1, for_s: 1, restart: hilsim}]", "takes only casd"},
                           {"[{at_s: 1, for_s: 1, line: {bauds: 9}}]", "bauds"},
                           {"[{at_s: 1, for_s: 1, unplug: fcu, vehicle: left}]",
                            "[0].vehicle: there is no vehicle 'left'; vehicles are iris0"},
                           {"[{at_s: 1, explode: imu}]", "needs one of"},
                           {"[{at_s: 1, dorp: imu}]", "; did you mean 'drop'?"},
                           {"[{at_s: 1, drop: barometre}]", "; did you mean 'barometer'?"},
                           {"[{at_s: 1, for_s: 1, unplgu: fcu}]",
                            "[0].unplgu: there is no such fault; did you mean 'unplug'?"},
                           {"[{at_s: 1, for_s: 1, unplug: fcu, vehicle: iriso}]",
                            "vehicles are iris0; did you mean 'iris0'?"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.text);
    const std::string error = error_of(row.text);
    EXPECT_NE(error.find(row.sentence), std::string::npos) << error;
    EXPECT_NE(error.find("scenario.yaml:1"), std::string::npos) << error;
  }
}

TEST(ScenarioFaults, BefallTheVehicleThatTheyNameOrEachOfThem) {
  const ScenarioFaults faults = faults_of(
      "[{at_s: 1, for_s: 2, unplug: fcu, vehicle: right}, {at_s: 1, for_s: 1, line: {}},"
      " {at_s: 1, for_s: 1, restart: casd}, {at_s: 3, drop: gps, vehicle: left},"
      " {at_s: 4, drop: imu}]",
      {"left", "right"});
  std::vector<std::size_t> bench;
  for (const BenchFault& fault : faults.bench) bench.push_back(fault.vehicle);
  EXPECT_EQ(bench, (std::vector<std::size_t>{1, 0, 1, 0}));
  ASSERT_EQ(faults.vehicle.size(), 2U);
  EXPECT_EQ(faults.vehicle[0].vehicle, 0U);
  EXPECT_FALSE(faults.vehicle[1].vehicle);
}

TEST(BenchFaultScript, AsksTheVehicleThatTheFaultIsAbout) {
  BenchFaultScript script(
      faults_of("[{when: altitude > 2, for_s: 9, unplug: fcu}, {at_s: 1, for_s: 1, restart: casd}]",
                {"left", "right"})
          .bench);
  std::vector<VehicleReport> vehicles(2);
  vehicles[1].p_N = {0, 0, -3};
  const auto events = script.update(at_time(seconds(1)), vehicles, "hold");
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].fault->vehicle, 1U);
  EXPECT_EQ(script.history_of(0).size(), 1U);  // a fault of casd hits both
  EXPECT_EQ(script.history_of(1).size(), 2U);
}

TEST(BenchFaultScript, BeginsAndEndsEachFaultOnce) {
  BenchFaultScript script(faults_of("[{at_s: 1, for_s: 2, unplug: fcu}]").bench);
  const std::vector<VehicleReport> alone(1);
  EXPECT_TRUE(script.update(at_time(milliseconds(900)), alone, "hold").empty());
  const auto begun = script.update(at_time(seconds(1)), alone, "hold");
  ASSERT_EQ(begun.size(), 1U);
  EXPECT_TRUE(begun[0].begins);
  EXPECT_TRUE(script.update(at_time(seconds(2)), alone, "hold").empty());
  const auto ended = script.update(at_time(seconds(3)), alone, "hold");
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_FALSE(ended[0].begins);
  EXPECT_TRUE(script.update(at_time(seconds(9)), alone, "hold").empty());
  ASSERT_EQ(script.history_of(0).size(), 1U);
  EXPECT_EQ(script.history_of(0)[0].begin, at_time(seconds(1)));
  EXPECT_EQ(script.history_of(0)[0].end, at_time(seconds(3)));
}

TEST(BenchFaultScript, ALineHasThePropertiesOfTheFaultThatBeganLastAndGoesOn) {
  BenchFaultScript script(
      faults_of("[{name: long, at_s: 1, for_s: 5, line: {baud: 57600}}]").bench);
  BenchFault by_hand =
      faults_of("[{name: hand, at_s: 9, for_s: 1, line: {baud: 115200}}]").bench.front();
  const std::vector<VehicleReport> alone(1);
  EXPECT_FALSE(script.line_is_faulty(0));
  script.update(at_time(seconds(1)), alone, "hold");
  EXPECT_TRUE(script.line_is_faulty(0));
  EXPECT_FALSE(script.line_is_faulty(1));
  script.add_begun(std::move(by_hand), at_time(seconds(2)));
  EXPECT_EQ(script.line_of(0)->line.baud, 115200);
  const auto ended = script.update(at_time(seconds(3)), alone, "hold");
  ASSERT_EQ(ended.size(), 1U) << "one begun by hand is not begun again";
  EXPECT_EQ(ended[0].fault->name, "hand");
  ASSERT_NE(script.line_of(0), nullptr);
  EXPECT_EQ(script.line_of(0)->line.baud, 57600) << "it does not heal the other";
  script.update(at_time(seconds(6)), alone, "hold");
  EXPECT_EQ(script.line_of(0), nullptr);
}

TEST(BenchFaultScript, AsksTheEstimateOrTheTruth) {
  BenchFaultScript script(
      faults_of("[{name: a, when: altitude > 2 and phase == hold, for_s: 1, unplug: fcu},"
                " {name: b, when: altitude > 2, of: truth, for_s: 1, restart: casd}]")
          .bench);
  std::vector<VehicleReport> vehicles(1);
  VehicleReport& vehicle = vehicles.front();
  vehicle.p_N = {0, 0, -3};
  EXPECT_TRUE(script.update(at_time(seconds(1)), vehicles, "takeoff").empty());
  ASSERT_EQ(script.update(at_time(seconds(2)), vehicles, "hold").size(), 1U);
  vehicle.truth = Motion{.p_m = {0, 0, 2.5}};
  const auto events = script.update(at_time(milliseconds(2500)), vehicles, "hold");
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].fault->name, "b");
}

}  // namespace
}  // namespace cas::hils
