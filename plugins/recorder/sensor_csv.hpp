// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "libsim/api/messages.hpp"
#include "plugins/recorder/csv_writer.hpp"

namespace cas::sim {

/// Every sample of every sensor, one CSV file per topic, in D and N as on the wire but in SI:
/// imu.csv, gps.csv, magnetometer.csv, barometer.csv, rangefinder.csv, motor_command.csv.
class SensorCsv {
 public:
  SensorCsv() = default;
  /// @throws base::ConfigError
  explicit SensorCsv(const std::filesystem::path& folder);

  void write(const ImuSample& sample);
  void write(const GpsSample& sample);
  void write(const MagnetometerSample& sample);
  void write(const BarometerSample& sample);
  void write(const RangeSample& sample);
  void write(base::SimTime time, const MotorCommand& command);
  void close();

 private:
  CsvWriter imu_;
  CsvWriter gps_;
  CsvWriter magnetometer_;
  CsvWriter barometer_;
  CsvWriter range_;
  CsvWriter command_;
};

}  // namespace cas::sim
