// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/recorder/flight_csv.hpp"

#include "base/earth/frames.hpp"

namespace cas::sim {

std::array<double, kTruthColumns> truth_row(base::SimTime time, const BodyState& state,
                                            const Eigen::Vector4d& omega) {
  const Eigen::Vector3d p_N = base::swap_WN(state.p_WB);
  const Eigen::Vector3d v_N = base::swap_WN(state.v_WB);
  const Eigen::Vector3d rpy = base::euler_rpy(base::q_ND_from_q_WB(state.q_WB));
  const Eigen::Vector3d w_D = base::swap_BD(state.w_WB_B);
  return {base::to_seconds(time),
          p_N.x(),
          p_N.y(),
          -p_N.z(),
          v_N.x(),
          v_N.y(),
          -v_N.z(),
          rpy.x(),
          rpy.y(),
          rpy.z(),
          w_D.x(),
          w_D.y(),
          w_D.z(),
          omega[0],
          omega[1],
          omega[2],
          omega[3]};
}

SensorCsv::SensorCsv(const std::filesystem::path& folder)
    : imu_(folder / "imu.csv",
           "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2"),
      gps_(folder / "gps.csv",
           "time_s,fix_type,satellites,lat_deg,lon_deg,alt_m,vn_m_s,ve_m_s,vd_m_s,eph_m,epv_m"),
      magnetometer_(folder / "magnetometer.csv", "time_s,x_gauss,y_gauss,z_gauss"),
      barometer_(folder / "barometer.csv", "time_s,pressure_pa,temperature_degc"),
      range_(folder / "rangefinder.csv", "time_s,distance_m,valid"),
      command_(folder / "motor_command.csv",
               "time_s,sensor_time_s,kind,armed,value1,value2,value3,value4") {}

void SensorCsv::write(const ImuSample& sample) {
  const Eigen::Vector3d w_D = base::swap_BD(sample.angular_rate_B);
  const Eigen::Vector3d f_D = base::swap_BD(sample.specific_force_B);
  imu_.row({base::to_seconds(sample.time), w_D.x(), w_D.y(), w_D.z(), f_D.x(), f_D.y(), f_D.z()});
}

void SensorCsv::write(const GpsSample& sample) {
  const Eigen::Vector3d& v_N = sample.velocity_N;
  gps_.row({base::to_seconds(sample.time), static_cast<double>(sample.fix_type),
            static_cast<double>(sample.satellites), sample.position.lat_deg,
            sample.position.lon_deg, sample.position.alt_m, v_N.x(), v_N.y(), v_N.z(), sample.eph_m,
            sample.epv_m});
}

void SensorCsv::write(const MagnetometerSample& sample) {
  const Eigen::Vector3d field_D = base::swap_BD(sample.field_B_gauss);
  magnetometer_.row({base::to_seconds(sample.time), field_D.x(), field_D.y(), field_D.z()});
}

void SensorCsv::write(const BarometerSample& sample) {
  barometer_.row({base::to_seconds(sample.time), sample.pressure_pa, sample.temperature_degc});
}

void SensorCsv::write(const RangeSample& sample) {
  range_.row({base::to_seconds(sample.time), sample.distance_m, sample.valid ? 1.0 : 0.0});
}

void SensorCsv::write(base::SimTime time, const MotorCommand& command) {
  const Eigen::Vector4d& u = command.values;
  command_.row({base::to_seconds(time), base::to_seconds(command.sensor_time),
                static_cast<double>(command.kind), command.armed ? 1.0 : 0.0, u[0], u[1], u[2],
                u[3]});
}

void SensorCsv::close() {
  for (CsvWriter* file : {&imu_, &gps_, &magnetometer_, &barometer_, &range_, &command_}) {
    file->close();
  }
}

}  // namespace cas::sim
