// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/sensor_figures.hpp"

#include <algorithm>
#include <cmath>

#include "base/angles.hpp"
#include "base/config/sensor_sheets.hpp"

namespace cas::fcu {
namespace {

using base::kRadPerDeg;
using Eigen::Vector3d;

constexpr double kMetresPerPascal = 0.0873;          // ISA at 488 m
constexpr double kLatLonStep_m = 0.0111 / 3.4641;    // 1e-7 degree on the wire, uniform
constexpr double kVelocityStep_m_s = 0.01 / 3.4641;  // 1 cm/s on the wire, uniform

/// Deviation of one sample, in the sheet's unit.
Vector3d white(const base::WhiteNoise& noise, double rate_hz) {
  return noise.figure() * noise.per_sample(rate_hz);
}

/// Random walk per square root of a second, in the sheet's unit: the largest of the axes.
double walk(const base::Drift& drift) {
  if (drift.bias_walk) return drift.bias_walk->maxCoeff();
  return drift.stddev ? drift.stddev->maxCoeff() * std::sqrt(2 / drift.time_constant_s) : 0;
}

/// Noise of one sample. Four rotors of unlike phase shake each axis.
Vector3d shaken(const base::TriadSheet& sheet, double rate_hz) {
  const Vector3d noise = white(sheet.noise, rate_hz);
  return (noise.cwiseAbs2() + 2 * sheet.vibration.cwiseAbs2()).cwiseSqrt();
}

void read_imu(const base::ImuSheet& sheet, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.imu_hz = sheet.rate_hz;
  p.gyro_noise_rad_s = kRadPerDeg * shaken(sheet.gyro, sheet.rate_hz);
  p.accel_noise_m_s2 = shaken(sheet.accel, sheet.rate_hz);
  out.gyro_bias_walk_rad_s = kRadPerDeg * walk(sheet.gyro.drift);
  out.accel_bias_walk_m_s2 = walk(sheet.accel.drift);
  p.gyro_bias_walk_rad_s = std::max(p.gyro_bias_walk_rad_s, out.gyro_bias_walk_rad_s);
  p.accel_bias_walk_m_s2 = std::max(p.accel_bias_walk_m_s2, out.accel_bias_walk_m_s2);
  p.gyro_bias_initial_rad_s = std::max(p.gyro_bias_initial_rad_s,
                                       2 * kRadPerDeg * sheet.gyro.turn_on_bias_stddev.maxCoeff());
  p.accel_bias_initial_m_s2 =
      std::max(p.accel_bias_initial_m_s2, 2 * sheet.accel.turn_on_bias_stddev.maxCoeff());
}

void read_gps(const base::GpsSheet& sheet, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.gps_hz = sheet.rate_hz;
  const Vector3d position = white(sheet.position, sheet.rate_hz);
  p.gps_position_noise_m = std::hypot(position.head<2>().maxCoeff(), kLatLonStep_m);
  p.gps_height_noise_m = std::max(position.z(), 0.002);
  p.gps_velocity_noise_m_s =
      std::hypot(white(sheet.velocity, sheet.rate_hz).maxCoeff(), kVelocityStep_m_s);
  p.gps_delay_s = sheet.delay_s;
}

void read_magnetometer(const base::MagnetometerSheet& sheet, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.mag_hz = sheet.rate_hz;
  p.mag_noise_gauss = std::max(white(sheet.noise, sheet.rate_hz).maxCoeff(), 5e-4);
  p.body_field_initial_gauss =
      std::max(p.body_field_initial_gauss, sheet.hard_iron_gauss.cwiseAbs().maxCoeff());
}

void read_barometer(const base::BarometerSheet& sheet, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.baro_hz = sheet.rate_hz;
  p.baro_noise_m = std::max(kMetresPerPascal * white(sheet.noise, sheet.rate_hz).maxCoeff(), 0.01);
  out.baro_offset_walk_m = kMetresPerPascal * walk(sheet.drift);
  p.baro_offset_walk_m = std::max(p.baro_offset_walk_m, out.baro_offset_walk_m);
}

}  // namespace

SensorFigures sensor_figures(const base::ConfigNode& sensors) {
  SensorFigures out;
  if (const auto node = sensors.find("imu")) read_imu(base::read_imu_sheet(*node), out);
  if (const auto node = sensors.find("gps")) read_gps(base::read_gps_sheet(*node), out);
  if (const auto node = sensors.find("magnetometer"))
    read_magnetometer(base::read_magnetometer_sheet(*node), out);
  if (const auto node = sensors.find("barometer"))
    read_barometer(base::read_barometer_sheet(*node), out);
  return out;
}

}  // namespace cas::fcu
