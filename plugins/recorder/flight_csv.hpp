// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/recorder/csv_writer.hpp"

namespace cas::sim {

/// Columns of truth.csv before those of the rotors.
inline constexpr int kMotionColumns = 13;
/// Behind the rotors, of a vehicle with a pitot tube: the true airspeed.
inline constexpr int kAirspeedColumns = 1;
/// One line of truth.csv, as many columns as the header of its vehicle.
using TruthRow = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor,
                               kMotionColumns + base::kMaxRotors + kAirspeedColumns, 1>;

/// Names of the columns of truth.csv: a speed for each rotor.
std::string truth_header(int rotors, bool has_airspeed);
/// One line of truth.csv: x north, y east, z up; roll, pitch, yaw of D in N; p, q, r in D.
/// @param airspeed_m_s  of a vehicle that has the column
TruthRow truth_row(base::SimTime time, const BodyState& state, const base::RotorVector& omega_rad_s,
                   std::optional<double> airspeed_m_s = {});
/// Speed of the centre of gravity through the air.
double true_airspeed_m_s(const BodyState& state, const Environment& air);
/// Values of a motor command that are recorded: U1..U4, or the outputs that drive something.
int command_values(const base::Vehicle& vehicle);

/// Every sample of every sensor, one CSV file per topic, in D and N as on the wire but in SI:
/// imu.csv, gps.csv, magnetometer.csv, barometer.csv, rangefinder.csv, motor_command.csv;
/// airspeed.csv of a vehicle with a pitot tube.
class SensorCsv {
 public:
  SensorCsv() = default;
  /// @param folder    of the files @param commands  see command_values()
  /// @throws base::ConfigError
  SensorCsv(const base::ResultPlace& folder, int commands, bool has_airspeed);

  void write(const ImuSample& sample);
  void write(const GpsSample& sample);
  void write(const MagnetometerSample& sample);
  void write(const BarometerSample& sample);
  void write(const RangeSample& sample);
  void write(const AirspeedSample& sample);
  void write(base::SimTime time, const MotorCommand& command);
  void close();

 private:
  CsvWriter imu_;
  CsvWriter gps_;
  CsvWriter magnetometer_;
  CsvWriter barometer_;
  CsvWriter range_;
  CsvWriter airspeed_;
  CsvWriter command_;
  int commands_ = 0;
};

}  // namespace cas::sim
