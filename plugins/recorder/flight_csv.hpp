// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/recorder/csv_writer.hpp"

namespace cas::sim {

/// Columns of truth.csv before those of the rotors.
inline constexpr int kMotionColumns = 13;
/// Behind the rotors, of a vehicle with a pitot tube: the true airspeed.
inline constexpr int kAirspeedColumns = 1;
/// Behind these, of a vehicle with a wing: angle of attack, sideslip, load factor; then its
/// surfaces.
inline constexpr int kWingColumns = 3;
/// One line of truth.csv, as many columns as the header of its vehicle.
using TruthRow = Eigen::Matrix<
    double, Eigen::Dynamic, 1, Eigen::ColMajor,
    kMotionColumns + base::kMaxRotors + kAirspeedColumns + kWingColumns + base::kMaxOutputs, 1>;

/// How a vehicle with a wing meets the air.
struct WingTruth {
  double alpha_rad = 0;    ///< angle of attack of the centre of gravity, nose up; 0 at rest
  double beta_rad = 0;     ///< sideslip, positive in air from the right; 0 at rest
  double load_factor = 0;  ///< specific force along the vehicle's upward axis, in g; 1 at rest
  ActuatorValues deflection_rad = ActuatorValues::Zero(0);  ///< in the order of the vehicle file
};
WingTruth wing_truth(const BodyState& state, const Environment& air,
                     const ActuatorValues& deflection_rad);

/// Names of the columns of truth.csv: a speed for each rotor.
/// @param surfaces  of a vehicle with a wing
std::string truth_header(int rotors, bool has_airspeed, std::optional<int> surfaces = {});
/// One line of truth.csv: x north, y east, z up; roll, pitch, yaw of D in N; p, q, r in D.
/// @param airspeed_m_s, wing  of a vehicle that has the columns
TruthRow truth_row(base::SimTime time, const BodyState& state, const base::RotorVector& omega_rad_s,
                   std::optional<double> airspeed_m_s = {},
                   const std::optional<WingTruth>& wing = {});
/// Speed of the centre of gravity through the air.
double true_airspeed_m_s(const BodyState& state, const Environment& air);
/// Values of a motor command that are recorded: U1..U4, or the outputs that drive something.
int command_values(const base::Vehicle& vehicle);

/// Every sample of every sensor, one CSV file per topic, in D and N as on the wire but in SI:
/// imu.csv, gps.csv, magnetometer.csv, barometer.csv, rangefinder.csv, motor_command.csv;
/// airspeed.csv of a vehicle with a pitot tube; imu_2.csv and so on of one with several of a kind.
class SensorCsv {
 public:
  SensorCsv() = default;
  /// @param folder    of the files @param commands  see command_values()
  /// @param further   names of the sensors beside the first of a kind: "imu_2"
  /// @throws base::ConfigError
  SensorCsv(const base::ResultPlace& folder, int commands, bool has_airspeed,
            const std::vector<std::string>& further = {});

  // @param number  of the sensor, from 1; further ones are those of the constructor
  void write(const ImuSample& sample, int number = 1);
  void write(const GpsSample& sample, int number = 1);
  void write(const MagnetometerSample& sample, int number = 1);
  void write(const BarometerSample& sample, int number = 1);
  void write(const RangeSample& sample, int number = 1);
  void write(const AirspeedSample& sample, int number = 1);
  void write(base::SimTime time, const MotorCommand& command);
  void close();

 private:
  static constexpr std::size_t kMostOfAKind = 3;  // base::kSensorKinds
  using Files = std::array<CsvWriter, kMostOfAKind>;

  void open(Files& files, const base::ResultPlace& folder, const std::string& sensor,
            const char* header, const std::vector<std::string>& further);

  Files imu_;
  Files gps_;
  Files magnetometer_;
  Files barometer_;
  Files range_;
  CsvWriter airspeed_;
  CsvWriter command_;
  int commands_ = 0;
};

}  // namespace cas::sim
