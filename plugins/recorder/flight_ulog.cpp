// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/recorder/flight_ulog.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "base/earth/frames.hpp"

namespace cas::sim {
namespace {

enum Topic : std::uint16_t {
  kPosition,
  kAttitude,
  kAngularVelocity,
  kImu,
  kGps,
  kMagnetometer,
  kBarometer,
  kRange,
  kRotors,
  kCommand,
  kAirspeedTruth,  // this and the next: of a vehicle with a pitot tube
  kDifferentialPressure,
  kWing,  // of a vehicle with a wing
  kTopics,
};

constexpr std::array<UlogTopic, kTopics> kLogged{
    {{"vehicle_local_position_groundtruth", "float x;float y;float z;float vx;float vy;float vz"},
     {"vehicle_attitude_groundtruth", "float[4] q"},
     {"vehicle_angular_velocity_groundtruth", "float[3] xyz"},
     {"sensor_combined", "float[3] gyro_rad;float[3] accelerometer_m_s2"},
     {"sensor_gps",
      "double latitude_deg;double longitude_deg;double altitude_msl_m;float vel_n_m_s;float "
      "vel_e_m_s;float vel_d_m_s;float eph;float epv;uint8_t fix_type;uint8_t satellites_used"},
     {"sensor_mag", "float x;float y;float z"},
     {"sensor_baro", "float pressure;float temperature"},
     {"distance_sensor", "float current_distance;float min_distance;float max_distance;bool valid"},
     {"rotor_speeds", "omega_rad_s"},
     {"motor_command", "values;uint8_t kind;bool armed"},
     {"airspeed_groundtruth", "float true_airspeed_m_s"},
     {"differential_pressure", "float differential_pressure_pa"},
     {"wing_groundtruth", {}}}};

/// Opens a log of the topics above, rotors and command with arrays of the vehicle's lengths.
UlogFile open_log(const base::ResultPlace& place, int rotors, int commands, bool has_airspeed,
                  std::optional<int> surfaces) {
  const auto array = [](int length, std::string_view fields) {
    return "float[" + std::to_string(length) + "] " + std::string(fields);
  };
  auto logged = kLogged;
  const std::string speeds = array(rotors, logged[kRotors].fields);
  const std::string values = array(commands, logged[kCommand].fields);
  const std::string wing = surfaces ? wing_fields(*surfaces) : std::string();
  logged[kRotors].fields = speeds;
  logged[kCommand].fields = values;
  logged[kWing].fields = wing;
  if (!has_airspeed) logged[kAirspeedTruth].fields = logged[kDifferentialPressure].fields = {};
  return UlogFile(place, logged);
}

}  // namespace

FlightUlog::FlightUlog(const base::ResultPlace& place, int rotors, int commands, bool has_airspeed,
                       std::optional<int> surfaces)
    : commands_(commands), file_(open_log(place, rotors, commands, has_airspeed, surfaces)) {}

void FlightUlog::write_truth(base::SimTime time, const BodyState& state,
                             std::optional<double> airspeed_m_s,
                             const std::optional<WingTruth>& wing) {
  const Eigen::Quaterniond q = base::q_ND_from_q_WB(state.q_WB);
  file_.write(
      kPosition,
      UlogRecord(time).put_floats(base::swap_WN(state.p_WB)).put_floats(base::swap_WN(state.v_WB)));
  file_.write(kAttitude,
              UlogRecord(time).put_float(q.w()).put_float(q.x()).put_float(q.y()).put_float(q.z()));
  file_.write(kAngularVelocity, UlogRecord(time).put_floats(base::swap_BD(state.w_WB_B)));
  if (airspeed_m_s) file_.write(kAirspeedTruth, UlogRecord(time).put_float(*airspeed_m_s));
  if (wing) {
    file_.write(kWing, UlogRecord(time)
                           .put_float(wing->alpha_rad)
                           .put_float(wing->beta_rad)
                           .put_float(wing->load_factor)
                           .put_floats(wing->deflection_rad));
  }
}

void FlightUlog::write(const ImuSample& sample) {
  file_.write(kImu, UlogRecord(sample.time)
                        .put_floats(base::swap_BD(sample.angular_rate_B))
                        .put_floats(base::swap_BD(sample.specific_force_B)));
}

void FlightUlog::write(const GpsSample& sample) {
  file_.write(kGps, UlogRecord(sample.time)
                        .put(sample.position.lat_deg)
                        .put(sample.position.lon_deg)
                        .put(sample.position.alt_m)
                        .put_floats(sample.velocity_N)
                        .put_float(sample.eph_m)
                        .put_float(sample.epv_m)
                        .put(sample.fix_type)
                        .put(sample.satellites));
}

void FlightUlog::write(const MagnetometerSample& sample) {
  file_.write(kMagnetometer,
              UlogRecord(sample.time).put_floats(base::swap_BD(sample.field_B_gauss)));
}

void FlightUlog::write(const BarometerSample& sample) {
  file_.write(
      kBarometer,
      UlogRecord(sample.time).put_float(sample.pressure_pa).put_float(sample.temperature_degc));
}

void FlightUlog::write(const RangeSample& sample) {
  file_.write(kRange, UlogRecord(sample.time)
                          .put_float(sample.distance_m)
                          .put_float(sample.min_m)
                          .put_float(sample.max_m)
                          .put(sample.valid));
}

void FlightUlog::write(const AirspeedSample& sample) {
  file_.write(kDifferentialPressure,
              UlogRecord(sample.time).put_float(sample.differential_pressure_pa));
}

void FlightUlog::write(const RotorSpeeds& speeds) {
  file_.write(kRotors, UlogRecord(speeds.time).put_floats(speeds.omega_rad_s));
}

void FlightUlog::write(base::SimTime time, const MotorCommand& command) {
  ActuatorValues values = ActuatorValues::Zero(commands_);
  const Eigen::Index known = std::min(values.size(), command.values.size());
  values.head(known) = command.values.head(known);
  file_.write(kCommand, UlogRecord(time)
                            .put_floats(values)
                            .put(static_cast<std::uint8_t>(command.kind))
                            .put(command.armed));
}

}  // namespace cas::sim
