// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/earth/frames.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/recorder/csv_writer.hpp"
#include "plugins/recorder/flight_csv.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/ulog_reader.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

/// A folder of this test alone, removed at its end.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "cas_recorder_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(CsvWriter, WritesNumbersThatReadBackExactly) {
  const Folder folder;
  CsvWriter csv({folder.path(), "deep/a.csv"}, "a,b,c");
  csv.row({0.1, -1e300, 12345678.875});
  csv.close();
  EXPECT_EQ(lines_of(folder / "deep/a.csv"),
            (std::vector<std::string>{"a,b,c", "0.1,-1e+300,12345678.875"}));
}

TEST(CsvWriter, SaysWhichFileCannotBeWritten) {
  const std::string said = test::refusal([] { CsvWriter csv({"/proc", "no/such.csv"}, "a"); });
  EXPECT_NE(said.find("/proc/no/such.csv"), std::string::npos) << said;
}

TEST(TruthRow, HasNorthEastUpAndAnglesOfForwardRightDown) {
  BodyState state;
  state.p_WB = {1, 2, 3};  // east, north, up
  state.v_WB = {4, 5, 6};
  state.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0.1, -0.2, 0.3));
  state.w_WB_B = {0.7, 0.8, 0.9};
  const auto row = truth_row(base::SimTime(std::chrono::milliseconds(1500)), state,
                             Eigen::Vector4d(10, 20, 30, 40));
  const std::array<double, 17> expected{1.5, 2,   1,    3,    5,  4,  6,  0.1, -0.2,
                                        0.3, 0.7, -0.8, -0.9, 10, 20, 30, 40};
  ASSERT_EQ(row.size(), 17);
  for (int i = 0; i < 17; ++i) {
    EXPECT_NEAR(row[i], expected[static_cast<std::size_t>(i)], 1e-12) << i;
  }
}

/// Level flight to the north, nose up by `alpha` and the air from the right by `beta`, at rest of
/// acceleration.
TEST(WingTruth, HasTheAnglesOfTheAirAndTheLoadFactor) {
  const double alpha = 0.1;
  const double beta = -0.05;
  BodyState state{.v_WB = {3 + 20 * std::sin(beta), 20 * std::cos(beta), 0},
                  .q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0, alpha, 0)),
                  .a_WB = {0, 0, test::kGravity}};
  Environment air;
  air.wind_W = {3, 0, 0};
  air.gravity_W = {0, 0, -test::kGravity};
  const WingTruth wing = wing_truth(state, air, Eigen::Vector2d(0.2, -0.3));
  constexpr double kRounding = 1e-12;
  EXPECT_NEAR(wing.alpha_rad, std::atan2(std::sin(alpha), std::cos(alpha)), kRounding);
  EXPECT_NEAR(wing.beta_rad, beta, kRounding);
  EXPECT_NEAR(wing.load_factor, 2 * std::cos(alpha), kRounding);
  EXPECT_EQ(wing_truth({}, air, {}).load_factor, 1);
  EXPECT_EQ(wing_truth({}, {}, {}).alpha_rad, 0);
  const auto row = truth_row({}, state, base::RotorVector::Zero(1), 20.0, wing);
  ASSERT_EQ(row.size(), 13 + 1 + 1 + 3 + 2);
  EXPECT_EQ(row.tail(2), Eigen::Vector2d(0.2, -0.3));
}

TEST(RecorderPlugin, HasTheSurfacesOfAPlane) {
  const Folder folder;
  test::PluginHarness harness(std::chrono::milliseconds(10), folder.path(), "plane");
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("aero", "{}");
  harness.add("recorder", "{file: truth.csv, rate_hz: 100, ulog: a.ulg}");
  harness.world.model_states.begin()->second = {0.1, 0, 0, 0, 0, -0.25};
  harness.run(std::chrono::milliseconds(20));
  harness.finish();
  const auto lines = lines_of(folder / "truth.csv");
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0], truth_header(1, false, 6));
  EXPECT_TRUE(
      lines[0].ends_with("alpha_rad,beta_rad,load_factor,deflection1_rad,deflection2_rad,"
                         "deflection3_rad,deflection4_rad,deflection5_rad,deflection6_rad"))
      << lines[0];
  EXPECT_TRUE(lines[1].ends_with(",1,0,0,0,0,0,0")) << lines[1];
  EXPECT_TRUE(lines[3].ends_with(",1,0.1,0,0,0,0,-0.25")) << lines[3];
  const test::UlogReader log((folder / "a.ulg").string());
  const auto& wing = log.messages("wing_groundtruth");
  ASSERT_EQ(wing.size(), 3U);
  EXPECT_EQ(log.value("wing_groundtruth", wing[2], "deflection_rad", 5), -0.25);
  EXPECT_EQ(log.value("wing_groundtruth", wing[2], "load_factor"), 1);
  EXPECT_FALSE(log.formats().contains("airspeed_groundtruth"));
}

TEST(RecorderPlugin, WritesFromTimeZeroAtItsRate) {
  const Folder folder;
  test::PluginHarness harness(std::chrono::milliseconds(1), folder.path());
  harness.add("recorder", "{file: truth.csv, rate_hz: 100}");
  harness.run(std::chrono::seconds(1));
  harness.finish();
  const auto lines = lines_of(folder / "truth.csv");
  ASSERT_EQ(lines.size(), 102U);  // header, time zero, 100 samples
  EXPECT_EQ(lines[0], truth_header(4, false));
  EXPECT_EQ(lines[1].substr(0, 2), "0,");
  EXPECT_EQ(lines[2].substr(0, 5), "0.01,");
  EXPECT_EQ(lines[101].substr(0, 2), "1,");
}

TEST(RecorderPlugin, WritesBelowItsFolderAlone) {
  const Folder folder;
  for (const char* keys :
       {"{file: ../truth.csv, rate_hz: 100}", "{file: /tmp/truth.csv, rate_hz: 100}",
        "{file: truth.csv, rate_hz: 100, sensor_dir: /tmp/sensors}",
        "{file: truth.csv, rate_hz: 100, sensor_dir: a/../..}",
        "{file: truth.csv, rate_hz: 100, ulog: ../flight.ulg}"}) {
    test::PluginHarness harness(std::chrono::milliseconds(1), folder.path());
    const std::string said = test::refusal([&] { harness.add("recorder", keys); });
    EXPECT_NE(said.find("below the folder of results alone"), std::string::npos)
        << keys << ": " << said;
  }
}

TEST(RecorderPlugin, FollowsNoSymlinkInItsFolder) {
  const Folder folder;
  std::ofstream(folder / "precious") << "keep me";
  std::filesystem::create_directory(folder / "out");
  std::filesystem::create_symlink(folder / "precious", folder / "out/truth.csv");
  test::PluginHarness harness(std::chrono::milliseconds(1), folder / "out");
  harness.add("recorder", "{file: truth.csv, rate_hz: 100}");
  harness.run(std::chrono::milliseconds(50));
  harness.finish();
  EXPECT_EQ(lines_of(folder / "precious"), std::vector<std::string>{"keep me"});
  EXPECT_EQ(lines_of(folder / "out/truth.csv").size(), 7U);
}

TEST(RecorderPlugin, BeginsAnewAfterReset) {
  const Folder folder;
  test::PluginHarness harness(std::chrono::milliseconds(1), folder.path());
  harness.add("recorder", "{file: truth.csv, rate_hz: 100}");
  harness.run(std::chrono::seconds(1));
  harness.reset();
  harness.run(std::chrono::milliseconds(50));
  harness.finish();
  EXPECT_EQ(lines_of(folder / "truth.csv").size(), 7U);
}

constexpr const char* kImu = "{rate_hz: 500, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.05}";
constexpr const char* kGpsKeys =
    "{rate_hz: 5, position_stddev_m: 0.3, velocity_stddev_m_s: 0.1, eph_m: 0.42, epv_m: 0.3, "
    "satellites: 10}";

TEST(RecorderPlugin, WritesEverySampleOfEverySensor) {
  const Folder folder;
  test::PluginHarness harness(std::chrono::milliseconds(1), folder.path());
  harness.add("imu", kImu);
  harness.add("gps", kGpsKeys);
  harness.add("recorder", "{file: truth.csv, rate_hz: 100, sensor_dir: sensors}");
  harness.run(std::chrono::seconds(1));
  harness.finish();
  const auto imu = lines_of(folder / "sensors/imu.csv");
  ASSERT_EQ(imu.size(), 501U);
  EXPECT_EQ(imu[1].substr(0, 6), "0.002,");
  EXPECT_EQ(lines_of(folder / "sensors/gps.csv").size(), 6U);
  EXPECT_EQ(lines_of(folder / "sensors/barometer.csv").size(), 1U);  // nothing was published
}

TEST(RecorderPlugin, WritesSomeReturnsOfEachLidarTwiceASecond) {
  const Folder folder;
  test::PluginHarness harness(std::chrono::milliseconds(1), folder.path());
  harness.world.body.p_WB = {1, 2, 3};
  const std::string pattern = cas::test::source_dir() + "/config/lidars/vlp16.yaml";
  for (int lidar = 0; lidar < 2; ++lidar) {
    harness.add("lidar", "{pattern: " + pattern + ", rate_hz: 10, min_m: 0.1, max_m: 50}");
  }
  harness.add("recorder", "{file: truth.csv, rate_hz: 100, clouds: run/clouds.csv}");
  harness.run(std::chrono::seconds(2));
  harness.finish();
  const auto rows = lines_of(folder / "run/clouds.csv");
  ASSERT_GT(rows.size(), 1U);
  EXPECT_EQ(rows[0], "time_s,east_m,north_m,up_m");
  std::map<std::string, int> returns;  // by the time of the scans
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto comma = rows[i].find(',');
    ++returns[rows[i].substr(0, comma)];
    EXPECT_EQ(rows[i].substr(rows[i].rfind(',') + 1), "0") << "the ground";
  }
  ASSERT_EQ(returns.size(), 3U) << "from 0.5 s on";
  for (const auto& [time, count] : returns) {
    EXPECT_GT(count, 2 * 300) << "at " << time;
    EXPECT_LE(count, 2 * 600) << "at " << time;
  }
}

TEST(RecorderPlugin, WithoutALidarWritesNoReturns) {
  const Folder folder;
  test::PluginHarness harness(std::chrono::milliseconds(1), folder.path());
  harness.add("recorder", "{file: truth.csv, rate_hz: 100, clouds: run/clouds.csv}");
  harness.run(std::chrono::seconds(1));
  harness.finish();
  EXPECT_FALSE(std::filesystem::exists(folder / "run"));
}

TEST(RecorderPlugin, WritesALogThatKeepsTheRulesOfUlog) {
  const Folder folder;
  test::PluginHarness harness(std::chrono::milliseconds(1), folder.path());
  harness.world.body.p_WB = {1, 2, 3};
  const auto commands = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("imu", kImu);
  harness.add("gps", kGpsKeys);
  harness.add("recorder", "{file: truth.csv, rate_hz: 100, ulog: flight.ulg}");
  harness.run(std::chrono::seconds(1));
  MotorCommand command;
  command.values = Eigen::Vector4d(15, 0.1, 0.2, 0.3);
  command.armed = true;
  commands.publish(command);
  harness.finish();

  const test::UlogReader log((folder / "flight.ulg").string());
  EXPECT_EQ(log.info("sys_name"), "CAS");
  EXPECT_EQ(log.formats().size(), 10U);
  const auto& positions = log.messages("vehicle_local_position_groundtruth");
  ASSERT_EQ(positions.size(), 101U);
  EXPECT_EQ(positions[0].timestamp, 0U);
  EXPECT_EQ(positions[100].timestamp, 1'000'000U);
  EXPECT_EQ(log.value("vehicle_local_position_groundtruth", positions[0], "x"), 2);   // north
  EXPECT_EQ(log.value("vehicle_local_position_groundtruth", positions[0], "z"), -3);  // down
  const auto& imu = log.messages("sensor_combined");
  ASSERT_EQ(imu.size(), 500U);
  EXPECT_NEAR(log.value("sensor_combined", imu[0], "accelerometer_m_s2", 2), -test::kGravity, 0.5);
  ASSERT_EQ(log.messages("sensor_gps").size(), 5U);
  EXPECT_EQ(log.value("sensor_gps", log.messages("sensor_gps")[0], "satellites_used"), 10);
  EXPECT_FLOAT_EQ(static_cast<float>(
                      log.value("motor_command", log.messages("motor_command").at(0), "values", 3)),
                  0.3F);
  EXPECT_FALSE(log.has("sensor_baro"));
}

}  // namespace
}  // namespace cas::sim
