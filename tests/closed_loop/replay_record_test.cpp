// SPDX-License-Identifier: BSD-3-Clause
// The record of a whole flight, held to the run's other records.
#include "hils/replay/replay_record.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/read_file.hpp"
#include "hils/measure/tracking.hpp"
#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using nlohmann::json;

std::vector<double> values_of(const json& column) {
  std::vector<double> values;
  double sum = 0;
  for (const json& difference : column.at("d")) {
    sum += difference.get<double>();
    values.push_back(sum * column.at("k").get<double>());
  }
  return values;
}

class FlightRecord : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new cas::test::TemporaryFolder;
    RunRequest request;
    request.scenario = Scenario::load(hover_with_lidar());
    request.seed = 2;
    request.out = folder_->path();
    run_ = new RunResult(evaluate(request, run_on_virtual_clock(request)));
    record_ = new json(json::parse(replay_record(request, *run_)));
    EXPECT_EQ(replay_record(request, *run_), replay_record(request, *run_));
  }
  static void TearDownTestSuite() {
    delete record_;
    delete run_;
    delete folder_;
  }
  static std::filesystem::path hover_with_lidar() {
    const auto hover =
        std::filesystem::path(cas::test::source_dir()) / "config/scenarios/hover.yaml";
    return folder_->write("hover.yaml",
                          base::read_file(hover).value() +
                              "plugins: [{plugin: lidar, pattern: ../lidars/depth_camera.yaml, "
                              "rate_hz: 1, min_m: 0.1, max_m: 50}]\n");
  }
  static const json& vehicle() { return record_->at("vehicles").at(0); }
  static const VehicleResult& flown() { return run_->vehicles.front(); }

  static inline const cas::test::TemporaryFolder* folder_ = nullptr;
  static inline const RunResult* run_ = nullptr;
  static inline const json* record_ = nullptr;
};

TEST_F(FlightRecord, TellsOfALineOnlyWhereItsSpeedCounts) {
  EXPECT_EQ(record_->at("line"), json({{"type", "serial"}, {"baud", 921600.0}}));
  RunRequest lockstep;
  lockstep.scenario = Scenario::load(cas::test::source_dir() + "/config/scenarios/hover.yaml");
  lockstep.seed = 2;
  lockstep.out = folder_->path();
  lockstep.clock = Clock::kLockstep;
  EXPECT_EQ(json::parse(replay_record(lockstep, *run_)).at("line"), json({{"type", "lockstep"}}));
}

TEST_F(FlightRecord, HasTheTruthAt50Hz) {
  const std::vector<PoseSample> truth = read_truth(flown().record.truth_csv);
  const json& columns = vehicle().at("truth");
  const std::vector<double> t = values_of(columns.at("t"));
  const std::vector<double> z = values_of(columns.at("z"));
  const std::vector<double> rotor = values_of(columns.at("rotor4"));
  ASSERT_EQ(t.size(), (truth.size() + 1) / 2);
  for (std::size_t i = 0; i < t.size(); ++i) {
    ASSERT_NEAR(t[i], 1e-6 * static_cast<double>(truth[2 * i].time_us), 0.001);
    ASSERT_NEAR(z[i], truth[2 * i].pose.z_m, 0.001);
    ASSERT_NEAR(rotor[i], truth[2 * i].omega_rad_s[3], 0.6);
  }
}

TEST_F(FlightRecord, HasWhatItsLidarSaw) {
  const json& columns = vehicle().at("clouds");
  const std::vector<double> t = values_of(columns.at("t"));
  const std::vector<double> u = values_of(columns.at("u"));
  ASSERT_GT(t.size(), 5000U);
  EXPECT_GT(t.back(), 40);
  for (std::size_t i = 0; i < t.size(); ++i) {
    ASSERT_NEAR(u[i], 0, 0.011) << "the ground, to a centimetre, at " << t[i] << " s";
  }
}

TEST_F(FlightRecord, HasTheReferenceThatTheRunIsJudgedBy) {
  const std::vector<double> t = values_of(vehicle().at("reference").at("t"));
  const std::vector<double> z = values_of(vehicle().at("reference").at("z"));
  const Stage& hold = *flown().record.hold;
  const double start = read_truth(flown().record.truth_csv).front().pose.z_m;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (t[i] < base::to_seconds(hold.begin) || t[i] > base::to_seconds(hold.end)) continue;
    ASSERT_NEAR(z[i], 2.5 + start, 0.002);
  }
}

TEST_F(FlightRecord, HopsHaveThePacketsOfTheAccount) {
  const json& hops = vehicle().at("link").at("hops");
  ASSERT_EQ(hops.size(), 4U);
  const auto window = flown().figures.window;
  for (const json& hop : hops) {
    const json& message = hop.at("messages").at(0);
    std::uint64_t left = 0;
    std::uint64_t arrived = 0;
    for (const json& bin : message.at("bins")) {
      const std::uint64_t second = bin.at(0);
      if (second * 1'000'000 < window.begin_usec || (second + 1) * 1'000'000 > window.end_usec) {
        continue;
      }
      left += bin.at(1).get<std::uint64_t>();
      arrived += bin.at(2).get<std::uint64_t>();
      EXPECT_LE(bin.at(3).get<double>(), bin.at(4).get<double>());  // median, 99 %
    }
    EXPECT_GT(left, 1000U);
    EXPECT_EQ(left, arrived) << hop.at("from") << " to " << hop.at("to");
  }
  const json& tape = vehicle().at("link").at("tapes").at(5);
  EXPECT_EQ(tape.at("around"), "now");
  EXPECT_NEAR(static_cast<double>(tape.at("hops").at("sim>casd").size()), 10, 2);  // 500 Hz, 20 ms
}

TEST_F(FlightRecord, HasWhatTheVehicleSaid) {
  const json& log = vehicle().at("log");
  bool has_estimate = false;
  for (const json& message : log.at("messages")) {
    const std::size_t samples = message.at("t").at("d").size();
    for (const json& field : message.at("fields")) {
      ASSERT_EQ(field.at("values").at("d").size(), samples) << message.at("name");
    }
    if (message.at("name") == "LOCAL_POSITION_NED") has_estimate = samples > 500;
  }
  EXPECT_TRUE(has_estimate);
  bool armed = false;
  for (const json& state : log.at("states")) armed = armed || (state.at(1).get<int>() & 128) != 0;
  EXPECT_TRUE(armed);
}

TEST_F(FlightRecord, HasTheChecksOfTheVerdict) {
  EXPECT_EQ(vehicle().at("checks").size(), flown().verdict.checks.size());
  EXPECT_EQ(record_->at("verdict").at("passed"), run_->verdict.passed);
  EXPECT_EQ(vehicle().at("scene").at("rotors").size(), 4U);
}

TEST_F(FlightRecord, OfALogAloneHasNoTruth) {
  const json alone = json::parse(tlog_record(flown().record.flight_tlog));
  EXPECT_FALSE(alone.at("vehicles").at(0).contains("truth"));
  EXPECT_GT(alone.at("vehicles").at(0).at("log").at("messages").size(), 5U);
  EXPECT_NEAR(alone.at("duration_s").get<double>(), record_->at("duration_s").get<double>(), 2);
}

}  // namespace
}  // namespace cas::hils
