// SPDX-License-Identifier: BSD-3-Clause
// flight.ulg of a whole flight, read by the rules of the specification and held to the run's other
// records.
#include "hils/ulog/run_ulog.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hils/measure/tracking.hpp"
#include "mavlink_gen/services/px4_modes.hpp"
#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/plugins/ulog_reader.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using cas::test::UlogReader;

/// One flight in which a gain is changed, and its log.
class Logged {
 public:
  Logged() {
    request_.scenario =
        Scenario::load(cas::test::source_dir() + "/config/scenarios/gain_tuning.yaml");
    request_.architecture = Architecture::kTcas;
    request_.seed = 3;
    request_.out = folder_.path();
    record_ = run_on_virtual_clock(request_).front();
    write_ulog(request_, record_, 0);
  }
  std::string file() const { return (folder_.path() / "flight.ulg").string(); }
  const RunRequest& request() const { return request_; }
  const RunRecord& record() const { return record_; }

 private:
  cas::test::TemporaryFolder folder_;
  RunRequest request_;
  RunRecord record_;
};

class FlightUlog : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    flight_ = new Logged;
    log_ = new UlogReader(flight_->file());
  }
  static void TearDownTestSuite() {
    delete log_;
    delete flight_;
    log_ = nullptr;
    flight_ = nullptr;
  }

  static double at(const std::string& topic, const UlogReader::Message& message,
                   const std::string& field, std::size_t index = 0) {
    return log_->value(topic, message, field, index);
  }
  /// Values of a field that follow each other, each once.
  static std::vector<int> values_of(const std::string& topic, const std::string& field) {
    std::vector<int> values;
    for (const auto& message : log_->messages(topic)) {
      const int value = static_cast<int>(at(topic, message, field));
      if (values.empty() || values.back() != value) values.push_back(value);
    }
    return values;
  }
  static double yaw_of(const std::string& topic, const UlogReader::Message& m,
                       const std::string& q) {
    const double w = at(topic, m, q, 0);
    const double x = at(topic, m, q, 1);
    const double y = at(topic, m, q, 2);
    const double z = at(topic, m, q, 3);
    return std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  }

  static inline const Logged* flight_ = nullptr;
  static inline const UlogReader* log_ = nullptr;
};

TEST_F(FlightUlog, HasTheTruthOfTheRun) {
  const std::vector<PoseSample> truth = read_truth(flight_->record().truth_csv);
  const std::string position = "vehicle_local_position_groundtruth";
  const std::string attitude = "vehicle_attitude_groundtruth";
  ASSERT_EQ(log_->messages(position).size(), truth.size());
  ASSERT_EQ(log_->messages(attitude).size(), truth.size());
  ASSERT_EQ(log_->messages("rotor_speeds").size(), truth.size());
  constexpr double kFloat = 1e-5;  // ULog has 32 bits of them
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto& p = log_->messages(position)[i];
    ASSERT_NEAR(static_cast<double>(p.timestamp), static_cast<double>(truth[i].time_us), 1);
    ASSERT_NEAR(at(position, p, "x"), truth[i].pose.x_m, kFloat);
    ASSERT_NEAR(at(position, p, "y"), truth[i].pose.y_m, kFloat);
    ASSERT_NEAR(at(position, p, "z"), -truth[i].pose.z_m, kFloat);
    ASSERT_NEAR(at(position, p, "vx"), truth[i].v_m_s[0], kFloat);
    ASSERT_NEAR(at(position, p, "vz"), -truth[i].v_m_s[2], kFloat);
    ASSERT_NEAR(yaw_of(attitude, log_->messages(attitude)[i], "q"), truth[i].pose.yaw_rad, 1e-4);
    ASSERT_NEAR(at("rotor_speeds", log_->messages("rotor_speeds")[i], "omega_rad_s", 3),
                truth[i].omega_rad_s[3], 1e-3);
  }
}

TEST_F(FlightUlog, HasTheEstimateOfTheRun) {
  const RunRecord& record = flight_->record();
  const std::vector<PoseSample> estimate =
      read_estimate(record.flight_tlog, record.system, record.log_clock);
  const std::string topic = "vehicle_local_position";
  const auto& messages = log_->messages(topic);
  ASSERT_GE(messages.size(), estimate.size());
  const std::size_t before = messages.size() - estimate.size();  // of the first attitude
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const auto& m = messages[before + i];
    ASSERT_EQ(static_cast<std::int64_t>(m.timestamp), estimate[i].time_us);
    ASSERT_EQ(at(topic, m, "x"), estimate[i].pose.x_m);
    ASSERT_EQ(at(topic, m, "y"), estimate[i].pose.y_m);
    ASSERT_EQ(at(topic, m, "z"), -estimate[i].pose.z_m);
  }
  EXPECT_EQ(at(topic, messages.back(), "xy_valid"), 1);
  EXPECT_EQ(at(topic, messages.back(), "v_z_valid"), 1);
  EXPECT_EQ(at(topic, messages.front(), "xy_valid"), 0);  // before the estimator says so
}

TEST_F(FlightUlog, HasSetpointsThatTheVehicleFollows) {
  const std::int64_t begin = std::llround(1e6 * base::to_seconds(flight_->record().hold->begin));
  const std::int64_t end = std::llround(1e6 * base::to_seconds(flight_->record().hold->end));
  const auto mean = [&](const std::string& topic, const std::string& field, std::size_t index = 0) {
    double sum = 0;
    int count = 0;
    for (const auto& m : log_->messages(topic)) {
      const auto time = static_cast<std::int64_t>(m.timestamp);
      if (time < begin || time >= end) continue;
      sum += at(topic, m, field, index);
      ++count;
    }
    EXPECT_GT(count, 30) << topic;
    return sum / count;
  };
  EXPECT_NEAR(mean("vehicle_local_position_setpoint", "z"), -5, 0.1);
  EXPECT_EQ(mean("trajectory_setpoint", "position", 2),
            mean("vehicle_local_position_setpoint", "z"));
  EXPECT_NEAR(mean("vehicle_local_position", "z"), mean("vehicle_local_position_setpoint", "z"),
              0.2);
  // Hover thrust is demanded, sent and produced: about the same share of full thrust.
  const double wanted = -mean("vehicle_attitude_setpoint", "thrust_body", 2);
  EXPECT_GT(wanted, 0.1);
  EXPECT_NEAR(-mean("vehicle_rates_setpoint", "thrust_body", 2), wanted, 1e-6);
  EXPECT_NEAR(-mean("vehicle_thrust_setpoint", "xyz", 2), wanted, 0.05);
  EXPECT_NEAR(mean("vehicle_torque_setpoint", "xyz", 0), 0, 0.05);
  EXPECT_NEAR(mean("actuator_outputs", "output", 0),
              1000 + 1000 * mean("actuator_motors", "control"), 0.5);
  EXPECT_EQ(mean("actuator_outputs", "noutputs"), 4);
}

TEST_F(FlightUlog, TellsArmingModesAndLanding) {
  EXPECT_EQ(values_of("vehicle_status", "arming_state"), (std::vector<int>{1, 2, 1}));
  const std::vector<int> modes = values_of("vehicle_status", "nav_state");
  EXPECT_TRUE(std::set<int>(modes.begin(), modes.end()).contains(17)) << "AUTO_TAKEOFF";
  EXPECT_TRUE(std::set<int>(modes.begin(), modes.end()).contains(4)) << "AUTO_LOITER";
  EXPECT_TRUE(std::set<int>(modes.begin(), modes.end()).contains(18)) << "AUTO_LAND";
  EXPECT_EQ(values_of("vehicle_land_detected", "landed"), (std::vector<int>{1, 0, 1}));
  EXPECT_EQ(values_of("vehicle_status", "hil_state"), (std::vector<int>{1}));
  ASSERT_FALSE(log_->texts().empty());
  const auto has = [](const std::string& sentence) {
    return std::ranges::any_of(log_->texts(),
                               [&](const auto& text) { return text.text == sentence; });
  };
  // Longer than one STATUSTEXT.
  EXPECT_TRUE(has("Arming denied: waiting for the position estimate to settle"));
}

TEST_F(FlightUlog, HasTheParametersAndTheGainThatWasChangedInFlight) {
  EXPECT_EQ(log_->params().at("MAV_TYPE"), 2);
  EXPECT_EQ(log_->params().at("MC_ROLL_P"), 7);
  EXPECT_FLOAT_EQ(static_cast<float>(log_->params().at("MPC_XY_P")), 0.6F);  // the scenario's
  ASSERT_FALSE(log_->changes().empty());
  bool found = false;
  for (const auto& change : log_->changes()) {
    if (change.name != "MPC_XY_P") continue;
    found = true;
    EXPECT_EQ(change.value, 1.5);
    const double begin = base::to_seconds(flight_->record().hold->begin);
    EXPECT_LT(static_cast<double>(change.timestamp) * 1e-6, begin);
    EXPECT_GT(static_cast<double>(change.timestamp) * 1e-6, begin - 5);
  }
  EXPECT_TRUE(found);
}

TEST_F(FlightUlog, SaysWhatFlightReviewAsksOfALog) {
  EXPECT_EQ(log_->info("sys_name"), "CAS");
  EXPECT_EQ(log_->info("ver_hw"), "fcu_emulator");
  EXPECT_EQ(log_->info("cas_scenario"), "gain_tuning");
  EXPECT_EQ(log_->info("cas_seed"), "3");
  EXPECT_EQ(log_->info("ver_data_format"), std::string("\2\0\0\0", 4));
  EXPECT_EQ(log_->info("time_ref_utc"), std::string(4, '\0'));
  EXPECT_EQ(log_->info("ver_sw_release").back(), static_cast<char>(log_->info("ver_sw")[0] - '0'));
}

TEST_F(FlightUlog, HasEachSampleOfTheSensors) {
  const auto rows = [](const std::filesystem::path& file) {
    const std::string text = test::content(file);
    return static_cast<std::size_t>(std::ranges::count(text, '\n')) - 1;
  };
  const std::filesystem::path& sensors = flight_->record().sensors;
  EXPECT_EQ(log_->messages("sensor_combined").size(), rows(sensors / "imu.csv"));
  EXPECT_EQ(log_->messages("vehicle_gps_position").size(), rows(sensors / "gps.csv"));
  EXPECT_EQ(log_->messages("vehicle_magnetometer").size(), rows(sensors / "magnetometer.csv"));
  EXPECT_EQ(log_->messages("vehicle_air_data").size(), rows(sensors / "barometer.csv"));
  EXPECT_FALSE(log_->has("distance_sensor"));  // there is none
  const base::Geodetic home =
      std::optional<base::Geodetic>(flight_->request().scenario.home).value();
  const auto& imu = log_->messages("sensor_combined").front();
  EXPECT_NEAR(at("sensor_combined", imu, "accelerometer_m_s2", 2), -9.81, 1);
  const auto& gps = log_->messages("vehicle_gps_position").front();
  EXPECT_NEAR(at("vehicle_gps_position", gps, "latitude_deg"), home.lat_deg, 1e-4);
  const auto& air = log_->messages("vehicle_air_data").front();
  EXPECT_NEAR(at("vehicle_air_data", air, "baro_alt_meter"), 488, 5);
  const auto& place = log_->messages("vehicle_global_position_groundtruth").front();
  EXPECT_NEAR(at("vehicle_global_position_groundtruth", place, "alt"), 488, 1);
  const auto& estimated = log_->messages("vehicle_global_position").back();
  EXPECT_NEAR(at("vehicle_global_position", estimated, "lon"), home.lon_deg, 1e-3);
  const auto& battery = log_->messages("battery_status").front();
  EXPECT_EQ(at("battery_status", battery, "cell_count"), 4);
  EXPECT_NEAR(at("battery_status", battery, "voltage_v"), 16.2, 0.1);
}

TEST_F(FlightUlog, IsInOrderAndTheSameEachTime) {
  EXPECT_TRUE(log_->is_in_order());
  const std::string bytes = test::content(flight_->file());
  write_ulog(flight_->request(), flight_->record(), 0);
  EXPECT_TRUE(test::content(flight_->file()) == bytes);
}

TEST_F(FlightUlog, HasTheTopicsAndFieldsOfItsPage) {
  const std::string page = test::content(cas::test::source_dir() + "/docs/use/ulog.md");
  for (const auto& [topic, format] : log_->formats()) {
    const std::size_t row = page.find("| `" + topic + "`");
    ASSERT_NE(row, std::string::npos) << topic;
    const std::string line = page.substr(row, page.find('\n', row) - row);
    for (const auto& field : format.fields) {
      if (field.name == "timestamp") continue;
      EXPECT_NE(line.find("`" + field.name + "`"), std::string::npos) << topic << " " << field.name;
    }
  }
}

TEST(Px4NavState, IsThatOfTheModeInAHeartbeat) {
  EXPECT_EQ(mav::services::px4_nav_state(3U << 16U), 2);               // POSCTL
  EXPECT_EQ(mav::services::px4_nav_state(4U << 16U | 2U << 24U), 17);  // AUTO, TAKEOFF
  EXPECT_EQ(mav::services::px4_nav_state(4U << 16U | 7U << 24U), std::nullopt);
  EXPECT_EQ(mav::services::px4_nav_state(0), std::nullopt);
}

}  // namespace
}  // namespace cas::hils
