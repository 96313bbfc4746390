// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/recorder/flight_csv.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/config/sensor_names.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"

namespace cas::sim {

namespace {

std::string command_header(int values) {
  std::string header = "time_s,sensor_time_s,kind,armed";
  for (int i = 1; i <= values; ++i) header += fmt::format(",value{}", i);
  return header;
}

}  // namespace

std::string truth_header(int rotors, bool has_airspeed, std::optional<int> surfaces) {
  std::string header =
      "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,roll_rad,pitch_rad,yaw_rad,p_rad_s,q_rad_s,r_rad_s";
  for (int i = 1; i <= rotors; ++i) header += fmt::format(",omega{}_rad_s", i);
  if (has_airspeed) header += ",airspeed_m_s";
  if (surfaces) header += ",alpha_rad,beta_rad,load_factor";
  for (int i = 1; i <= surfaces.value_or(0); ++i) {
    header += fmt::format(",deflection{}_rad", i);
  }
  return header;
}

int command_values(const base::Vehicle& vehicle) {
  int most = 4;
  for (const base::Rotor& rotor : vehicle.rotors) {
    most = std::max(most, rotor.output + 1);
    if (rotor.tilt) most = std::max(most, rotor.tilt->output + 1);
  }
  if (!vehicle.aero) return most;
  for (const base::ControlSurface& surface : vehicle.aero->surfaces) {
    most = std::max(most, surface.output + 1);
  }
  return most;
}

TruthRow truth_row(base::SimTime time, const BodyState& state, const base::RotorVector& omega,
                   std::optional<double> airspeed_m_s, const std::optional<WingTruth>& wing) {
  const Eigen::Vector3d p_N = base::swap_WN(state.p_WB);
  const Eigen::Vector3d v_N = base::swap_WN(state.v_WB);
  const Eigen::Vector3d rpy = base::euler_rpy(base::q_ND_from_q_WB(state.q_WB));
  const Eigen::Vector3d w_D = base::swap_BD(state.w_WB_B);
  const Eigen::Index before = kMotionColumns + omega.size();
  const Eigen::Index of_wing = before + (airspeed_m_s ? kAirspeedColumns : 0);
  TruthRow row(of_wing + (wing ? kWingColumns + wing->deflection_rad.size() : 0));
  row.head(before) << base::to_seconds(time), p_N.x(), p_N.y(), -p_N.z(), v_N.x(), v_N.y(),
      -v_N.z(), rpy, w_D, omega;
  if (airspeed_m_s) row[before] = *airspeed_m_s;
  if (wing) {
    row.tail(row.size() - of_wing) << wing->alpha_rad, wing->beta_rad, wing->load_factor,
        wing->deflection_rad;
  }
  return row;
}

WingTruth wing_truth(const BodyState& state, const Environment& air,
                     const ActuatorValues& deflection_rad) {
  const Eigen::Quaterniond q_BW = state.q_WB.conjugate();
  const Eigen::Vector3d v_D = base::swap_BD(q_BW * (state.v_WB - air.wind_W));
  const Eigen::Vector3d f_B = q_BW * (state.a_WB - air.gravity_W);
  return {.alpha_rad = std::atan2(v_D.z(), v_D.x()),
          .beta_rad = std::atan2(v_D.y(), std::hypot(v_D.x(), v_D.z())),
          .load_factor = f_B.z() / base::kStandardGravity_m_s2,
          .deflection_rad = deflection_rad};
}

double true_airspeed_m_s(const BodyState& state, const Environment& air) {
  return (state.v_WB - air.wind_W).norm();
}

SensorCsv::SensorCsv(const base::ResultPlace& folder, int commands, bool has_airspeed,
                     const std::vector<std::string>& further)
    : command_({folder.out, folder.file / "motor_command.csv"}, command_header(commands)),
      commands_(commands) {
  open(imu_, folder, "imu",
       "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2",
       further);
  open(gps_, folder, "gps",
       "time_s,fix_type,satellites,lat_deg,lon_deg,alt_m,vn_m_s,ve_m_s,vd_m_s,eph_m,epv_m",
       further);
  open(magnetometer_, folder, "magnetometer", "time_s,x_gauss,y_gauss,z_gauss", further);
  open(barometer_, folder, "barometer", "time_s,pressure_pa,temperature_degc", further);
  open(range_, folder, "rangefinder", "time_s,distance_m,valid", further);
  if (has_airspeed) {
    airspeed_ =
        CsvWriter({folder.out, folder.file / "airspeed.csv"}, "time_s,differential_pressure_pa");
  }
}

void SensorCsv::open(Files& files, const base::ResultPlace& folder, const std::string& sensor,
                     const char* header, const std::vector<std::string>& further) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string name = base::sensor_name(sensor, static_cast<int>(i) + 1);
    if (i > 0 && std::ranges::find(further, name) == further.end()) continue;
    files[i] = CsvWriter({folder.out, folder.file / (name + ".csv")}, header);
  }
}

void SensorCsv::write(const ImuSample& sample, int number) {
  const Eigen::Vector3d w_D = base::swap_BD(sample.angular_rate_B);
  const Eigen::Vector3d f_D = base::swap_BD(sample.specific_force_B);
  imu_[static_cast<std::size_t>(number - 1)].row(
      {base::to_seconds(sample.time), w_D.x(), w_D.y(), w_D.z(), f_D.x(), f_D.y(), f_D.z()});
}

void SensorCsv::write(const GpsSample& sample, int number) {
  const Eigen::Vector3d& v_N = sample.velocity_N;
  gps_[static_cast<std::size_t>(number - 1)].row(
      {base::to_seconds(sample.time), static_cast<double>(sample.fix_type),
       static_cast<double>(sample.satellites), sample.position.lat_deg, sample.position.lon_deg,
       sample.position.alt_m, v_N.x(), v_N.y(), v_N.z(), sample.eph_m, sample.epv_m});
}

void SensorCsv::write(const MagnetometerSample& sample, int number) {
  const Eigen::Vector3d field_D = base::swap_BD(sample.field_B_gauss);
  magnetometer_[static_cast<std::size_t>(number - 1)].row(
      {base::to_seconds(sample.time), field_D.x(), field_D.y(), field_D.z()});
}

void SensorCsv::write(const BarometerSample& sample, int number) {
  barometer_[static_cast<std::size_t>(number - 1)].row(
      {base::to_seconds(sample.time), sample.pressure_pa, sample.temperature_degc});
}

void SensorCsv::write(const RangeSample& sample, int number) {
  range_[static_cast<std::size_t>(number - 1)].row(
      {base::to_seconds(sample.time), sample.distance_m, sample.valid ? 1.0 : 0.0});
}

void SensorCsv::write(const AirspeedSample& sample, int) {
  airspeed_.row({base::to_seconds(sample.time), sample.differential_pressure_pa});
}

void SensorCsv::write(base::SimTime time, const MotorCommand& command) {
  constexpr std::size_t kBefore = 4;
  std::array<double, kBefore + base::kMaxOutputs> row{
      base::to_seconds(time), base::to_seconds(command.sensor_time),
      static_cast<double>(command.kind), command.armed ? 1.0 : 0.0};
  const auto values = static_cast<std::size_t>(commands_);
  for (std::size_t i = 0; i < std::min(values, static_cast<std::size_t>(command.values.size()));
       ++i) {
    row[kBefore + i] = command.values[static_cast<Eigen::Index>(i)];
  }
  command_.row(std::span(row).first(kBefore + values));
}

void SensorCsv::close() {
  for (Files* files : {&imu_, &gps_, &magnetometer_, &barometer_, &range_}) {
    for (CsvWriter& file : *files) file.close();
  }
  airspeed_.close();
  command_.close();
}

}  // namespace cas::sim
