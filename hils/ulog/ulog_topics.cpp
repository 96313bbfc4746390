// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ulog/ulog_topics.hpp"

#include <array>
#include <string_view>

#include "base/config/vehicle.hpp"

namespace cas::hils {

namespace {

constexpr std::size_t kTopics = static_cast<std::size_t>(UlogTopicId::kWingTruth) + 1;

constexpr std::array<sim::UlogTopic, kTopics> kAll{
    {{"vehicle_attitude", "float[4] q"},
     {"vehicle_angular_velocity", "float[3] xyz"},
     {"vehicle_local_position",
      "float x;float y;float z;float vx;float vy;float vz;bool xy_valid;bool z_valid;bool "
      "v_xy_valid;bool v_z_valid"},
     {"vehicle_global_position", "double lat;double lon;float alt"},
     {"vehicle_attitude_setpoint", "float[4] q_d;float[3] thrust_body"},
     {"vehicle_rates_setpoint", "float roll;float pitch;float yaw;float[3] thrust_body"},
     {"vehicle_local_position_setpoint",
      "float x;float y;float z;float vx;float vy;float vz;float[3] acceleration;float yaw;float "
      "yawspeed"},
     {"trajectory_setpoint",
      "float[3] position;float[3] velocity;float[3] acceleration;float yaw;float yawspeed"},
     {"vehicle_torque_setpoint", "float[3] xyz"},
     {"vehicle_thrust_setpoint", "float[3] xyz"},
     {"actuator_motors", "float[12] control"},
     {"actuator_outputs", "uint32_t noutputs;float[16] output"},
     {"vehicle_status",
      "uint8_t arming_state;uint8_t nav_state;uint8_t hil_state;uint8_t "
      "system_type;uint8_t system_id;uint8_t component_id"},
     {"vehicle_land_detected", "bool landed"},
     {"battery_status",
      "float voltage_v;float current_a;float discharged_mah;float remaining;uint8_t cell_count"},
     {"sensor_combined", "float[3] gyro_rad;float[3] accelerometer_m_s2"},
     {"vehicle_gps_position",
      "double latitude_deg;double longitude_deg;double altitude_msl_m;float eph;float epv;float "
      "vel_m_s;float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;float cog_rad;uint8_t "
      "fix_type;uint8_t satellites_used"},
     {"vehicle_magnetometer", "float[3] magnetometer_ga"},
     {"vehicle_air_data", "float baro_alt_meter;float baro_pressure_pa;float ambient_temperature"},
     {"distance_sensor", "float current_distance;int8_t signal_quality"},
     {"vehicle_attitude_groundtruth", "float[4] q"},
     {"vehicle_angular_velocity_groundtruth", "float[3] xyz"},
     {"vehicle_local_position_groundtruth", "float x;float y;float z;float vx;float vy;float vz"},
     {"vehicle_global_position_groundtruth", "double lat;double lon;float alt"},
     {"rotor_speeds", "float[16] omega_rad_s"},
     {"airspeed_groundtruth", "float true_airspeed_m_s"},
     {"differential_pressure", "float differential_pressure_pa"},
     {"wing_groundtruth", {}}}};

}  // namespace

std::vector<sim::UlogTopic> ulog_topics(int rotors, bool has_airspeed,
                                        std::string_view wing_fields) {
  constexpr std::array<std::string_view, base::kMaxRotors> kSpeeds{
      "float[1] omega_rad_s",  "float[2] omega_rad_s",  "float[3] omega_rad_s",
      "float[4] omega_rad_s",  "float[5] omega_rad_s",  "float[6] omega_rad_s",
      "float[7] omega_rad_s",  "float[8] omega_rad_s",  "float[9] omega_rad_s",
      "float[10] omega_rad_s", "float[11] omega_rad_s", "float[12] omega_rad_s",
      "float[13] omega_rad_s", "float[14] omega_rad_s", "float[15] omega_rad_s",
      "float[16] omega_rad_s"};
  std::vector<sim::UlogTopic> topics(kAll.begin(), kAll.end());
  const auto fields = [&](UlogTopicId topic) -> std::string_view& {
    return topics[static_cast<std::size_t>(topic)].fields;
  };
  fields(UlogTopicId::kRotorSpeeds) = kSpeeds.at(static_cast<std::size_t>(rotors) - 1);
  if (!has_airspeed) {
    fields(UlogTopicId::kAirspeedTruth) = fields(UlogTopicId::kDifferentialPressure) = {};
  }
  fields(UlogTopicId::kWingTruth) = wing_fields;
  return topics;
}

}  // namespace cas::hils
