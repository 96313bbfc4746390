// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/sensor_figures.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace cas::fcu {
namespace {

using Eigen::Vector3d;

constexpr double kRadPerDeg = M_PI / 180;
constexpr double kMetresPerPascal = 0.0873;          // ISA at 488 m
constexpr double kLatLonStep_m = 0.0111 / 3.4641;    // 1e-7 degree on the wire, uniform
constexpr double kVelocityStep_m_s = 0.01 / 3.4641;  // 1 cm/s on the wire, uniform

/// One number for all axes, or three.
std::optional<Vector3d> axes(const base::ConfigNode& node, const std::string& key) {
  const auto child = node.find(key);
  if (!child) return std::nullopt;
  if (child->is_scalar()) return Vector3d::Constant(child->as<double>());
  return child->as<Vector3d>();
}

/// Deviation of one sample from `<name>stddev_<unit>` or `<name>density_<unit>_per_sqrt_hz`.
std::optional<Vector3d> white(const base::ConfigNode& node, const std::string& name,
                              const std::string& unit, double rate_hz) {
  if (const auto stddev = axes(node, name + "stddev_" + unit)) return stddev;
  if (const auto density = axes(node, name + "density_" + unit + "_per_sqrt_hz")) {
    return Vector3d(*density * std::sqrt(rate_hz));
  }
  return std::nullopt;
}

/// Random walk per square root of a second of `<name>bias_walk_...` or `<name>drift_stddev_...`.
double walk(const base::ConfigNode& node, const std::string& name, const std::string& unit) {
  if (const auto given = axes(node, name + "bias_walk_" + unit + "_per_sqrt_s")) {
    return given->maxCoeff();
  }
  const auto drift = axes(node, name + "drift_stddev_" + unit);
  if (!drift) return 0;
  const double tau = node.require<double>(name + "drift_time_constant_s");
  return drift->maxCoeff() * std::sqrt(2 / tau);
}

void read_imu(const base::ConfigNode& node, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.imu_hz = node.get<double>("rate_hz", out.rates.imu_hz);
  // Four rotors of unlike phase shake each axis.
  const auto shaken = [&](const Vector3d& noise, const std::string& key) {
    const Vector3d vibration = axes(node, key).value_or(Vector3d::Zero());
    return Vector3d((noise.cwiseAbs2() + 2 * vibration.cwiseAbs2()).cwiseSqrt());
  };
  if (const auto gyro = white(node, "gyro_", "deg_s", out.rates.imu_hz)) {
    p.gyro_noise_rad_s = kRadPerDeg * shaken(*gyro, "gyro_vibration_deg_s");
  }
  if (const auto accel = white(node, "accel_", "m_s2", out.rates.imu_hz)) {
    p.accel_noise_m_s2 = shaken(*accel, "accel_vibration_m_s2");
  }
  out.gyro_bias_walk_rad_s = kRadPerDeg * walk(node, "gyro_", "deg_s");
  out.accel_bias_walk_m_s2 = walk(node, "accel_", "m_s2");
  p.gyro_bias_walk_rad_s = std::max(p.gyro_bias_walk_rad_s, out.gyro_bias_walk_rad_s);
  p.accel_bias_walk_m_s2 = std::max(p.accel_bias_walk_m_s2, out.accel_bias_walk_m_s2);
  if (const auto bias = axes(node, "gyro_turn_on_bias_stddev_deg_s")) {
    p.gyro_bias_initial_rad_s =
        std::max(p.gyro_bias_initial_rad_s, 2 * kRadPerDeg * bias->maxCoeff());
  }
  if (const auto bias = axes(node, "accel_turn_on_bias_stddev_m_s2")) {
    p.accel_bias_initial_m_s2 = std::max(p.accel_bias_initial_m_s2, 2 * bias->maxCoeff());
  }
}

void read_gps(const base::ConfigNode& node, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.gps_hz = node.get<double>("rate_hz", out.rates.gps_hz);
  if (const auto noise = white(node, "position_", "m", out.rates.gps_hz)) {
    p.gps_position_noise_m = std::hypot(noise->head<2>().maxCoeff(), kLatLonStep_m);
    p.gps_height_noise_m = std::max(noise->z(), 0.002);
  }
  if (const auto noise = white(node, "velocity_", "m_s", out.rates.gps_hz)) {
    p.gps_velocity_noise_m_s = std::hypot(noise->maxCoeff(), kVelocityStep_m_s);
  }
  p.gps_delay_s = node.get<double>("delay_s", 0.0);
}

void read_magnetometer(const base::ConfigNode& node, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.mag_hz = node.get<double>("rate_hz", out.rates.mag_hz);
  if (const auto noise = white(node, "", "gauss", out.rates.mag_hz)) {
    p.mag_noise_gauss = std::max(noise->maxCoeff(), 5e-4);
  }
  if (const auto iron = axes(node, "hard_iron_gauss")) {
    p.body_field_initial_gauss = std::max(p.body_field_initial_gauss, iron->cwiseAbs().maxCoeff());
  }
}

void read_barometer(const base::ConfigNode& node, SensorFigures& out) {
  EstimatorParams& p = out.params;
  out.rates.baro_hz = node.get<double>("rate_hz", out.rates.baro_hz);
  if (const auto noise = white(node, "", "pa", out.rates.baro_hz)) {
    p.baro_noise_m = std::max(kMetresPerPascal * noise->maxCoeff(), 0.01);
  }
  out.baro_offset_walk_m = kMetresPerPascal * walk(node, "", "pa");
  p.baro_offset_walk_m = std::max(p.baro_offset_walk_m, out.baro_offset_walk_m);
}

}  // namespace

SensorFigures sensor_figures(const base::ConfigNode& sensors) {
  SensorFigures out;
  if (const auto node = sensors.find("imu")) read_imu(*node, out);
  if (const auto node = sensors.find("gps")) read_gps(*node, out);
  if (const auto node = sensors.find("magnetometer")) read_magnetometer(*node, out);
  if (const auto node = sensors.find("barometer")) read_barometer(*node, out);
  return out;
}

}  // namespace cas::fcu
