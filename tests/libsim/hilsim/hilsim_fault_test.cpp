// SPDX-License-Identifier: BSD-3-Clause
// A world file's fault script in the program hilsim: every kind of fault begins, shows, ends and is
// logged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using cas::test::ChildProcess;
using testing::HasSubstr;
using Row = std::vector<double>;

/// Rests on the ground for 4 s; every sensor is next to noiseless.
const std::string kWorld = R"(schema: 1
world: {gravity_m_s2: 9.80665, ground: true}
home: {lat_deg: 47.4, lon_deg: 8.5, alt_m: 488}
decimal_year: 2026.5
pace: free_run
vehicles:
  - name: iris0
    vehicle: )" + cas::test::source_dir() +
                           R"(/config/vehicles/iris_paper.yaml
    sensors: ideal
    plugins:
      - {plugin: wind}
      - {plugin: motor}
      - {plugin: imu}
      - {plugin: gps}
      - {plugin: magnetometer}
      - {plugin: barometer, wind_pressure_coefficient: 1}
      - {plugin: rangefinder, position_B_m: [0, 0, 0.2]}
      - plugin: fault
        faults:
          - {name: frozen, at_s: 1, for_s: 1, freeze: imu}
          - {name: dropped, at_s: 1, for_s: 1, drop: gps}
          - {name: biased, at_s: 1, for_s: 1, bias: {sensor: magnetometer, field_gauss: [0.1, 0, 0]}}
          - {name: scaled, at_s: 1, for_s: 1, scale: {sensor: rangefinder, distance: 2}}
          - {name: late, at_s: 2.505, for_s: 0.5, delay: {sensor: magnetometer, by_s: 0.1}}
          - {name: noisy, at_s: 1, for_s: 1, noise: {sensor: barometer, temperature_degc: 5}}
          - {name: stopped, at_s: 1, for_s: 1, rotor: {number: 1, stop: true}}
          - {name: weak, at_s: 1, for_s: 1, rotor: {number: 2, thrust_share: 0.5}}
          - {name: starved, at_s: 1, for_s: 1, voltage_share: 0.9}
          - {name: heavy, at_s: 1, for_s: 1, mass_factor: 1.3}
          - {name: shifted, at_s: 1, for_s: 1, cg_shift_B_m: [0.02, 0, 0]}
          - {name: gust, at_s: 3, for_s: 0.5, gust: {amplitude_m_s: [0, 10, 0], length_m: 0.2, hold_s: 9}}
          - {name: state, when: time > 3.2 and altitude < 5, until: time > 3.4, drop: rangefinder}
      - {plugin: recorder, file: truth.csv, rate_hz: 100, sensor_dir: .}
)";

/// One run of hilsim for all tests of this file.
class FaultScript : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new cas::test::TemporaryFolder();
    const std::string world = folder_->write("world.yaml", kWorld).string();
    const std::string stats = (folder_->path() / "stats.json").string();
    ChildProcess hilsim({cas::test::binary_dir() + "/bin/hilsim", world, "--duration", "4",
                         "--stats", stats, "--output", folder_->path().string()});
    exit_code_ = hilsim.wait_exit().value_or(-1);
    output_ = hilsim.output();
    const auto figures = nlohmann::json::parse(std::ifstream(stats));
    for (const auto& event : figures["plugins"]["fault@iris0"]["events"]) {
      events_[event["fault"].get<std::string>() + " " + event["event"].get<std::string>()] =
          event["time_s"];
    }
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  /// Rows whose stamp lies in (from, to].
  static std::vector<Row> rows(const std::string& file, double from_s, double to_s) {
    std::ifstream in(folder_->path() / file);
    std::string line;
    std::getline(in, line);  // heading
    std::vector<Row> rows;
    while (std::getline(in, line)) {
      std::istringstream cells(line);
      Row row;
      for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
      if (row[0] > from_s + 1e-9 && row[0] <= to_s + 1e-9) rows.push_back(std::move(row));
    }
    return rows;
  }
  static double mean(const std::vector<Row>& rows, std::size_t column) {
    double sum = 0;
    for (const Row& row : rows) sum += row[column];
    return sum / static_cast<double>(rows.size());
  }
  static double spread(const std::vector<Row>& rows, std::size_t column) {
    const double middle = mean(rows, column);
    double sum = 0;
    for (const Row& row : rows) sum += (row[column] - middle) * (row[column] - middle);
    return std::sqrt(sum / static_cast<double>(rows.size()));
  }

  static inline cas::test::TemporaryFolder* folder_ = nullptr;
  static inline int exit_code_ = -1;
  static inline std::string output_;
  static inline std::map<std::string, double> events_;
};

TEST_F(FaultScript, BeginsAndEndsEachFaultWhenItSays) {
  EXPECT_EQ(exit_code_, 0) << output_;
  for (const char* name : {"frozen", "dropped", "biased", "scaled", "noisy", "stopped", "weak",
                           "starved", "heavy", "shifted"}) {
    EXPECT_DOUBLE_EQ(events_[name + std::string(" begin")], 1) << name;
    EXPECT_DOUBLE_EQ(events_[name + std::string(" end")], 2) << name;
  }
  EXPECT_DOUBLE_EQ(events_["late begin"], 2.505);
  EXPECT_DOUBLE_EQ(events_["late end"], 3.005);
  EXPECT_DOUBLE_EQ(events_["state begin"], 3.201);
  EXPECT_DOUBLE_EQ(events_["state end"], 3.401);
}

TEST_F(FaultScript, LogsBeginAndEndOfEach) {
  for (const auto& [event, time] : events_) {
    const std::string name = event.substr(0, event.find(' '));
    EXPECT_THAT(output_, HasSubstr(name)) << "at " << time;
  }
  const auto lines = std::count(output_.begin(), output_.end(), '\n');
  EXPECT_GE(lines, static_cast<long>(events_.size())) << output_;
}

TEST_F(FaultScript, FreezesTheImu) {
  EXPECT_GT(spread(rows("imu.csv", 0, 1), 6), 1e-5);
  EXPECT_EQ(rows("imu.csv", 1, 2).size(), 500U);
  constexpr double kRounding = 1e-12;  // of the mean
  EXPECT_LT(spread(rows("imu.csv", 1.001, 2), 6), kRounding);
  EXPECT_GT(spread(rows("imu.csv", 2, 3), 6), 1e-5);
}

TEST_F(FaultScript, DropsTheGps) {
  EXPECT_EQ(rows("gps.csv", 0, 1).size(), 10U);
  EXPECT_EQ(rows("gps.csv", 1, 2).size(), 0U);
  EXPECT_EQ(rows("gps.csv", 2, 3).size(), 10U);
}

TEST_F(FaultScript, BiasesTheMagnetometerOnOneAxis) {
  const auto before = rows("magnetometer.csv", 0, 1);
  const auto during = rows("magnetometer.csv", 1, 2);
  EXPECT_NEAR(mean(during, 1) - mean(before, 1), 0.1, 1e-4);
  EXPECT_NEAR(mean(during, 2) - mean(before, 2), 0, 1e-4);
}

TEST_F(FaultScript, ScalesTheRangefinder) {
  const double distance_m = mean(rows("rangefinder.csv", 0, 1), 1);
  EXPECT_GT(distance_m, 0.2);
  EXPECT_NEAR(mean(rows("rangefinder.csv", 1, 2), 1), 2 * distance_m, 1e-3);
}

TEST_F(FaultScript, AddsNoiseToTheBarometer) {
  EXPECT_NEAR(spread(rows("barometer.csv", 1, 2), 2), 5, 1.5);  // 100 samples: 4 standard errors
  EXPECT_LT(spread(rows("barometer.csv", 2, 3), 2), 0.1);
}

TEST_F(FaultScript, DropsOnAStateUntilAnother) {
  EXPECT_EQ(rows("rangefinder.csv", 3.2, 3.4).size(), 0U);
  EXPECT_EQ(rows("rangefinder.csv", 3.41, 4).size(), 59U);
}

TEST_F(FaultScript, AGustRaisesThePressureOfAnExposedPort) {
  const double calm_pa = mean(rows("barometer.csv", 2, 3), 1);
  const double gust_pa = mean(rows("barometer.csv", 3.6, 4), 1);
  EXPECT_NEAR(gust_pa - calm_pa, 0.5 * 1.168 * 100, 1);  // rho v^2 / 2 at 488 m
}

}  // namespace
}  // namespace cas::sim
