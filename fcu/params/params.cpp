// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/params/params.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>

#include "base/earth/gravity.hpp"
#include "base/error.hpp"
#include "fcu/control/mixer.hpp"

namespace cas::fcu {

namespace {

Param param(std::string name, ParamType type, double initial, double low, double high) {
  return {.name = std::move(name),
          .type = type,
          .value = initial,
          .initial = initial,
          .start = initial,
          .low = low,
          .high = high};
}
Param real(std::string name, double initial, double low, double high) {
  return param(std::move(name), ParamType::kReal32, initial, low, high);
}
Param integer(std::string name, int initial, int low, int high) {
  return param(std::move(name), ParamType::kInt32, initial, low, high);
}

/// Rate loops: crossover in rad/s -> full-scale torque per rad/s for this airframe.
void add_rate_loops(std::vector<Param>& list, const base::Vehicle& vehicle) {
  constexpr double kTiltCrossover_rad_s = 20;
  constexpr double kYawCrossover_rad_s = 7;
  const Eigen::Vector3d& inertia = vehicle.inertia_kg_m2;
  const auto& scales = vehicle.scales;
  const double roll = kTiltCrossover_rad_s * inertia.x() / scales.u2_max_nm;
  const double pitch = kTiltCrossover_rad_s * inertia.y() / scales.u3_max_nm;
  const double yaw = kYawCrossover_rad_s * inertia.z() / scales.u4_max_nm;
  const struct {
    const char* axis;
    const char* limit;
    double p, i, d, max_deg_s;
  } loops[] = {{"ROLL", "MC_RR_INT_LIM", roll, 1.5 * roll, 0.012 * roll, 220},
               {"PITCH", "MC_PR_INT_LIM", pitch, 1.5 * pitch, 0.012 * pitch, 220},
               {"YAW", "MC_YR_INT_LIM", yaw, 0.8 * yaw, 0.0, 200}};
  for (const auto& loop : loops) {
    const std::string prefix = std::string("MC_") + loop.axis + "RATE_";
    list.push_back(real(prefix + "P", loop.p, 0, 5));
    list.push_back(real(prefix + "I", loop.i, 0, 10));
    list.push_back(real(prefix + "D", loop.d, 0, 0.5));
    list.push_back(real(prefix + "FF", 0, 0, 5));
    list.push_back(real(prefix + "K", 1, 0.01, 5));
    list.push_back(real(prefix + "MAX", loop.max_deg_s, 0, 1800));
    list.push_back(real(loop.limit, 0.3, 0, 1));
  }
}

void add_attitude(std::vector<Param>& list) {
  list.push_back(real("MC_ROLL_P", 7.0, 0, 20));
  list.push_back(real("MC_PITCH_P", 7.0, 0, 20));
  list.push_back(real("MC_YAW_P", 2.8, 0, 10));
  list.push_back(real("MC_YAW_WEIGHT", 0.4, 0.05, 1));
  list.push_back(real("IMU_GYRO_CUTOFF", 60, 0, 1000));
  list.push_back(real("IMU_DGYRO_CUTOFF", 30, 0, 1000));
}

void add_position(std::vector<Param>& list, const base::Vehicle& vehicle) {
  const double hover = vehicle.mass_kg * base::kStandardGravity_m_s2 / vehicle.scales.u1_max_n;
  list.push_back(real("MPC_XY_P", 1.5, 0, 5));
  list.push_back(real("MPC_Z_P", 1.3, 0, 5));
  list.push_back(real("MPC_XY_VEL_P_ACC", 4.0, 0, 15));
  list.push_back(real("MPC_XY_VEL_I_ACC", 0.7, 0, 60));
  list.push_back(real("MPC_XY_VEL_D_ACC", 0.2, 0, 5));
  list.push_back(real("MPC_Z_VEL_P_ACC", 5.0, 0, 15));
  list.push_back(real("MPC_Z_VEL_I_ACC", 2.0, 0, 60));
  list.push_back(real("MPC_Z_VEL_D_ACC", 0.0, 0, 5));
  list.push_back(real("MPC_XY_VEL_MAX", 12, 0.5, 30));
  list.push_back(real("MPC_XY_CRUISE", 5, 0.5, 20));
  list.push_back(real("MPC_VEL_MANUAL", 5, 0.5, 20));
  list.push_back(real("MPC_Z_VEL_MAX_UP", 3, 0.5, 8));
  list.push_back(real("MPC_Z_VEL_MAX_DN", 1.5, 0.5, 4));
  list.push_back(real("MPC_Z_V_AUTO_UP", 2, 0.3, 8));
  list.push_back(real("MPC_Z_V_AUTO_DN", 1.2, 0.3, 4));
  list.push_back(real("MPC_ACC_HOR", 3, 0.5, 15));
  list.push_back(real("MPC_ACC_UP_MAX", 3, 0.5, 10));
  list.push_back(real("MPC_ACC_DOWN_MAX", 2, 0.5, 8));
  list.push_back(real("MPC_JERK_AUTO", 8, 1, 80));
  list.push_back(real("MPC_TKO_SPEED", 1.2, 0.3, 5));
  list.push_back(real("MPC_LAND_SPEED", 0.6, 0.1, 3));
  list.push_back(real("MPC_LAND_ALT2", 3, 0, 30));
  list.push_back(real("MPC_TILTMAX_AIR", 45, 10, 80));
  list.push_back(real("MPC_TILTMAX_LND", 12, 10, 80));
  list.push_back(real("MPC_MAN_TILT_MAX", 35, 1, 70));
  list.push_back(real("MPC_MAN_Y_MAX", 120, 0, 400));
  list.push_back(real("MPC_HOLD_DZ", 0.1, 0, 1));
  list.push_back(real("MPC_THR_HOVER", hover, 0.1, 0.9));
  list.push_back(real("MPC_THR_MIN", 0.08, 0.02, 0.5));
  list.push_back(real("MPC_THR_MAX", 1.0, 0.3, 1));
  list.push_back(real("MPC_YAWRAUTO_MAX", 60, 0, 360));
}

/// The estimator's assumptions: figures of the data sheets; axes of D.
void add_estimator(std::vector<Param>& list, const EstimatorParams& p) {
  const char* axes[] = {"X", "Y", "Z"};
  for (int axis = 0; axis < 3; ++axis) {
    // Of one sample: rad/s and m/s^2.
    list.push_back(
        real(std::string("CAS_GYR_NOISE_") + axes[axis], p.gyro_noise_rad_s[axis], 1e-6, 1));
    list.push_back(
        real(std::string("CAS_ACC_NOISE_") + axes[axis], p.accel_noise_m_s2[axis], 1e-5, 20));
  }
  // Random walks, per square root of a second.
  list.push_back(real("CAS_GYR_B_WALK", p.gyro_bias_walk_rad_s, 0, 0.1));
  list.push_back(real("CAS_ACC_B_WALK", p.accel_bias_walk_m_s2, 0, 1));
  list.push_back(real("CAS_MAG_E_WALK", p.earth_field_walk_gauss, 0, 0.1));
  list.push_back(real("CAS_MAG_B_WALK", p.body_field_walk_gauss, 0, 0.1));
  list.push_back(real("CAS_BARO_WALK", p.baro_offset_walk_m, 0, 1));
  list.push_back(real("EKF2_GPS_P_NOISE", p.gps_position_noise_m, 0.001, 10));
  list.push_back(real("CAS_GPS_Z_NOISE", p.gps_height_noise_m, 0.001, 20));
  list.push_back(real("EKF2_GPS_V_NOISE", p.gps_velocity_noise_m_s, 0.001, 5));
  list.push_back(real("EKF2_BARO_NOISE", p.baro_noise_m, 0.001, 15));
  list.push_back(real("EKF2_MAG_NOISE", p.mag_noise_gauss, 0.0001, 1));
  list.push_back(real("EKF2_GPS_DELAY", 1000 * p.gps_delay_s, 0, 500));
  list.push_back(real("EKF2_GPS_P_GATE", 5, 1, 20));
  list.push_back(real("EKF2_GPS_V_GATE", 5, 1, 20));
  list.push_back(real("EKF2_BARO_GATE", 5, 1, 20));
  list.push_back(real("EKF2_MAG_GATE", 5, 1, 20));
  list.push_back(real("EKF2_ANGERR_INIT", p.tilt_initial_rad, 0.01, 0.5));
  list.push_back(real("EKF2_GBIAS_INIT", p.gyro_bias_initial_rad_s, 0, 0.5));
  list.push_back(real("EKF2_ABIAS_INIT", p.accel_bias_initial_m_s2, 0, 2));
  list.push_back(real("CAS_MAG_E_INIT", p.earth_field_initial_gauss, 0, 0.2));
  list.push_back(real("CAS_MAG_B_INIT", p.body_field_initial_gauss, 0, 0.2));
}

void add_safety(std::vector<Param>& list) {
  list.push_back(integer("COM_ARM_WO_GPS", 0, 0, 1));
  list.push_back(real("COM_DISARM_LAND", 2.0, -1, 20));
  list.push_back(real("COM_DISARM_PRFLT", 10.0, -1, 60));
  list.push_back(real("COM_SPOOLUP_TIME", 1.0, 0, 5));
  list.push_back(real("COM_OF_LOSS_T", 1.0, 0, 60));
  list.push_back(integer("COM_OBL_RC_ACT", 5, 0, 7));
  list.push_back(real("COM_RC_LOSS_T", 0.5, 0.1, 35));
  list.push_back(integer("COM_RC_IN_MODE", 3, 0, 4));
  list.push_back(integer("COM_DL_LOSS_T", 10, 5, 300));
  list.push_back(integer("COM_LOW_BAT_ACT", 3, 0, 3));
  list.push_back(integer("NAV_DLL_ACT", 0, 0, 6));
  list.push_back(integer("NAV_RCL_ACT", 2, 0, 6));
  list.push_back(real("FD_FAIL_R", 70, 60, 180));
  list.push_back(real("FD_FAIL_P", 70, 60, 180));
  list.push_back(real("FD_FAIL_TTRI", 0.3, 0.02, 5));
  list.push_back(integer("CBRK_FLIGHTTERM", 0, 0, 121212));
  list.push_back(real("BAT_LOW_THR", 0.15, 0, 1));
  list.push_back(real("BAT_CRIT_THR", 0.07, 0, 1));
  list.push_back(real("BAT_EMERGEN_THR", 0.05, 0, 1));
  list.push_back(integer("BAT1_N_CELLS", 4, 1, 16));
  list.push_back(real("SIM_BAT_DRAIN", 900, 1, 86400));
  list.push_back(real("SIM_BAT_MIN_PCT", 50, 0, 100));
  list.push_back(real("RTL_RETURN_ALT", 15, 0, 150));
  list.push_back(real("RTL_DESCEND_ALT", 5, 0, 100));
  list.push_back(real("RTL_LAND_DELAY", 0, -1, 300));
  list.push_back(real("MIS_TAKEOFF_ALT", 2.5, 0, 80));
  list.push_back(real("NAV_ACC_RAD", 1.0, 0.05, 200));
  list.push_back(real("NAV_MC_ALT_RAD", 0.8, 0.05, 200));
}

/// What only vehicles with more than four rotors, or tilted ones, have.
void add_rotors(std::vector<Param>& list, const base::Vehicle& vehicle) {
  if (vehicle.rotor_count() > 4) {
    // Rotors to leave out, 1 for the first, 2 for the second, 4 for the third ...
    list.push_back(integer("CAS_ROT_LOST", 0, 0, 65535));
    // Whether to look for rotors that give nothing.
    list.push_back(integer("CAS_ROT_DETECT", 1, 0, 1));
  }
  // Share of the force sideways that is used before the vehicle is tilted.
  if (Mixer(vehicle).side_force_n() > 0) list.push_back(real("CAS_SIDE_SHARE", 0.7, 0, 1));
}

/// MAV_TYPE by the number of rotors.
int vehicle_type(int rotors) {
  switch (rotors) {
    case 3:
      return 15;
    case 4:
      return 2;
    case 6:
      return 13;
    case 8:
      return 14;
    case 10:
      return 35;
    case 12:
      return 29;
    default:
      return 43;  // GENERIC_MULTIROTOR
  }
}

void add_system(std::vector<Param>& list, const base::Vehicle& vehicle) {
  list.push_back(integer("MAV_SYS_ID", vehicle.system_id, 1, 250));
  list.push_back(integer("MAV_COMP_ID", 1, 1, 250));
  list.push_back(integer("MAV_TYPE", vehicle_type(vehicle.rotor_count()), 0, 50));
  list.push_back(integer("SYS_AUTOSTART", 10016, 0, 9999999));
  list.push_back(integer("SYS_HITL", 1, 0, 2));
  // Nonzero: a sensor is there and calibrated, as ground stations read it.
  list.push_back(integer("CAL_GYRO0_ID", 1310988, 0, 2147483647));
  list.push_back(integer("CAL_ACC0_ID", 1310988, 0, 2147483647));
  list.push_back(integer("CAL_MAG0_ID", 197388, 0, 2147483647));
  list.push_back(integer("CAL_BARO0_ID", 6620172, 0, 2147483647));
  // The message that carries the answer: 0 HIL_CONTROLS (U1..U4), 1 HIL_ACTUATOR_CONTROLS (motors).
  list.push_back(integer("CAS_HIL_ACT", 0, 0, 1));
  // Time of a sensor message: 0 its own stamp, 1 its arrival.
  list.push_back(integer("CAS_STAMP_MODE", 0, 0, 1));
  // Built-in pattern flown in Hold: 0 none, 1 circle, 2 figure eight, 3 steps.
  list.push_back(integer("CAS_TRJ_SHAPE", 0, 0, 3));
  list.push_back(real("CAS_TRJ_SIZE", 2.0, 0.1, 50));
  list.push_back(real("CAS_TRJ_SPEED", 2.0, 0.1, 10));
  list.push_back(real("CAS_TRJ_PERIOD", 10.0, 1, 120));
}

/// All parameters with their defaults for an airframe, unsorted. Where PX4 has the same loop or
/// limit, the name and the unit are PX4's.
std::vector<Param> default_params(const base::Vehicle& vehicle, const EstimatorParams& estimator) {
  std::vector<Param> list;
  add_rate_loops(list, vehicle);
  add_attitude(list);
  add_position(list, vehicle);
  add_estimator(list, estimator);
  add_safety(list);
  add_rotors(list, vehicle);
  add_system(list, vehicle);
  return list;
}

double representable(ParamType type, double value) {
  if (type == ParamType::kInt32) return std::nearbyint(value);
  return static_cast<double>(static_cast<float>(value));
}

/// CRC-32 (polynomial 0xEDB88320, reflected, no inversion), one more byte.
std::uint32_t crc32_byte(std::uint32_t crc, std::uint8_t byte) {
  crc ^= byte;
  for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  return crc;
}

/// The parameters that `wanted` picks, as "NAME VALUE" lines.
std::string lines(const std::vector<Param>& params, bool (*wanted)(const Param&)) {
  constexpr int kDigits = 10;  // a float and an INT32 come back exactly
  std::ostringstream out;
  out.precision(kDigits);
  for (const Param& param : params) {
    if (wanted(param)) out << param.name << ' ' << param.value << '\n';
  }
  return out.str();
}

}  // namespace

ParamStore::ParamStore(const base::Vehicle& vehicle, const EstimatorParams& estimator)
    : params_(default_params(vehicle, estimator)) {
  for (Param& param : params_) {
    CAS_CHECK(param.name.size() <= 16);
    param.value = param.start = param.initial = representable(param.type, param.initial);
  }
  std::sort(params_.begin(), params_.end(),
            [](const Param& a, const Param& b) { return a.name < b.name; });
}

std::optional<std::size_t> ParamStore::index_of(std::string_view name) const {
  const auto place =
      std::lower_bound(params_.begin(), params_.end(), name,
                       [](const Param& param, std::string_view key) { return param.name < key; });
  if (place == params_.end() || place->name != name) return std::nullopt;
  return static_cast<std::size_t>(place - params_.begin());
}

double ParamStore::get(std::string_view name) const {
  const std::optional<std::size_t> index = index_of(name);
  CAS_CHECK(index.has_value());
  return params_[*index].value;
}

ParamSetResult ParamStore::set(std::string_view name, double value) {
  const std::optional<std::size_t> index = index_of(name);
  if (!index) return ParamSetResult::kUnknown;
  if (!std::isfinite(value)) return ParamSetResult::kNotANumber;
  Param& param = params_[*index];
  const double rounded = representable(param.type, value);
  // Bounds in the wire's precision: 0.1 as a float is a little above 0.1.
  if (rounded < representable(param.type, param.low) ||
      rounded > representable(param.type, param.high)) {
    return ParamSetResult::kOutOfRange;
  }
  if (rounded != param.value) {
    param.value = rounded;
    ++revision_;
  }
  return ParamSetResult::kOk;
}

void ParamStore::reset_to_defaults() {
  for (Param& param : params_) param.value = param.initial;
  ++revision_;
}

void ParamStore::mark_start() {
  for (Param& param : params_) param.start = param.value;
}

std::string ParamStore::changed_text() const {
  return lines(params_, [](const Param& param) { return param.value != param.start; });
}

std::string ParamStore::all_text() const {
  return lines(params_, [](const Param&) { return true; });
}

std::uint32_t ParamStore::hash() const {
  std::uint32_t crc = 0;
  for (const Param& param : params_) {
    for (const char c : param.name) crc = crc32_byte(crc, static_cast<std::uint8_t>(c));
    const auto bits = std::bit_cast<std::uint32_t>(to_wire(param));
    for (unsigned shift = 0; shift < 32; shift += 8) {
      crc = crc32_byte(crc, static_cast<std::uint8_t>(bits >> shift));
    }
  }
  return crc;
}

float ParamStore::to_wire(const Param& param) {
  if (param.type == ParamType::kReal32) return static_cast<float>(param.value);
  return std::bit_cast<float>(static_cast<std::int32_t>(param.value));
}

double ParamStore::from_wire(ParamType type, float field) {
  if (type == ParamType::kReal32) return static_cast<double>(field);
  return static_cast<double>(std::bit_cast<std::int32_t>(field));
}

}  // namespace cas::fcu
