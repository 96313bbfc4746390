// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string_view>

#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/recorder/csv_writer.hpp"

namespace cas::sim {

inline constexpr std::string_view kTruthHeader =
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,roll_rad,pitch_rad,yaw_rad,p_rad_s,q_rad_s,r_rad_s,"
    "omega1_rad_s,omega2_rad_s,omega3_rad_s,omega4_rad_s";
inline constexpr std::size_t kTruthColumns = 17;

/// One line of truth.csv: x north, y east, z up; roll, pitch, yaw of D in N; p, q, r in D.
std::array<double, kTruthColumns> truth_row(base::SimTime time, const BodyState& state,
                                            const Eigen::Vector4d& omega_rad_s);

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
