// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/params/param_binding.hpp"

#include <cmath>

namespace cas::fcu {
namespace {

constexpr double kRadPerDeg = M_PI / 180;
constexpr int kNoTermination = 121212;  // PX4's circuit breaker value

PidGains rate_gains(const ParamStore& store, const std::string& axis, const char* limit) {
  const std::string prefix = "MC_" + axis + "RATE_";
  const double k = store.get(prefix + "K");
  return {k * store.get(prefix + "P"), k * store.get(prefix + "I"), k * store.get(prefix + "D"),
          store.get(limit)};
}

/// Of a parameter that not every vehicle has; 0 without it.
double get_if_any(const ParamStore& store, std::string_view name) {
  return store.index_of(name) ? store.get(name) : 0.0;
}

Eigen::Vector3d three(const ParamStore& store, const std::string& prefix) {
  return {store.get(prefix + "X"), store.get(prefix + "Y"), store.get(prefix + "Z")};
}

}  // namespace

ControlParams control_params(const ParamStore& store) {
  constexpr double kWindLimit_m_s2 = 6;  // largest steady disturbance that is integrated away
  ControlParams p;
  p.rate_roll = rate_gains(store, "ROLL", "MC_RR_INT_LIM");
  p.rate_pitch = rate_gains(store, "PITCH", "MC_PR_INT_LIM");
  p.rate_yaw = rate_gains(store, "YAW", "MC_YR_INT_LIM");
  p.rate_feed_forward = {store.get("MC_ROLLRATE_FF"), store.get("MC_PITCHRATE_FF"),
                         store.get("MC_YAWRATE_FF")};
  p.rate_limit_rad_s =
      kRadPerDeg * Eigen::Vector3d(store.get("MC_ROLLRATE_MAX"), store.get("MC_PITCHRATE_MAX"),
                                   store.get("MC_YAWRATE_MAX"));
  p.gyro_cutoff_hz = store.get("IMU_GYRO_CUTOFF");
  p.dgyro_cutoff_hz = store.get("IMU_DGYRO_CUTOFF");
  p.roll_p = store.get("MC_ROLL_P");
  p.pitch_p = store.get("MC_PITCH_P");
  p.yaw_p = store.get("MC_YAW_P");
  p.yaw_weight = store.get("MC_YAW_WEIGHT");
  p.xy_p = store.get("MPC_XY_P");
  p.z_p = store.get("MPC_Z_P");
  p.xy_velocity = {store.get("MPC_XY_VEL_P_ACC"), store.get("MPC_XY_VEL_I_ACC"),
                   store.get("MPC_XY_VEL_D_ACC"), kWindLimit_m_s2};
  p.z_velocity = {store.get("MPC_Z_VEL_P_ACC"), store.get("MPC_Z_VEL_I_ACC"),
                  store.get("MPC_Z_VEL_D_ACC"), kWindLimit_m_s2};
  p.xy_velocity_limit_m_s = store.get("MPC_XY_VEL_MAX");
  p.z_velocity_up_limit_m_s = store.get("MPC_Z_VEL_MAX_UP");
  p.z_velocity_down_limit_m_s = store.get("MPC_Z_VEL_MAX_DN");
  p.tilt_limit_rad = kRadPerDeg * store.get("MPC_TILTMAX_AIR");
  p.hover_thrust = store.get("MPC_THR_HOVER");
  p.thrust_min = store.get("MPC_THR_MIN");
  p.thrust_max = store.get("MPC_THR_MAX");
  // HIL_CONTROLS has U1..U4 only, and the simulator makes speeds of all rotors of them.
  if (hil_params(store).answer_by_motor) {
    p.rotors_lost = static_cast<std::uint32_t>(get_if_any(store, "CAS_ROT_LOST"));
    p.detect_rotor_loss = get_if_any(store, "CAS_ROT_DETECT") != 0;
    p.side_share = get_if_any(store, "CAS_SIDE_SHARE");
  }
  return p;
}

EstimatorParams estimator_params(const ParamStore& store) {
  EstimatorParams p;
  p.gyro_noise_rad_s = three(store, "CAS_GYR_NOISE_");
  p.accel_noise_m_s2 = three(store, "CAS_ACC_NOISE_");
  p.gyro_bias_walk_rad_s = store.get("CAS_GYR_B_WALK");
  p.accel_bias_walk_m_s2 = store.get("CAS_ACC_B_WALK");
  p.earth_field_walk_gauss = store.get("CAS_MAG_E_WALK");
  p.body_field_walk_gauss = store.get("CAS_MAG_B_WALK");
  p.baro_offset_walk_m = store.get("CAS_BARO_WALK");
  p.gps_position_noise_m = store.get("EKF2_GPS_P_NOISE");
  p.gps_height_noise_m = store.get("CAS_GPS_Z_NOISE");
  p.gps_velocity_noise_m_s = store.get("EKF2_GPS_V_NOISE");
  p.baro_noise_m = store.get("EKF2_BARO_NOISE");
  p.mag_noise_gauss = store.get("EKF2_MAG_NOISE");
  p.tilt_initial_rad = store.get("EKF2_ANGERR_INIT");
  p.gyro_bias_initial_rad_s = store.get("EKF2_GBIAS_INIT");
  p.accel_bias_initial_m_s2 = store.get("EKF2_ABIAS_INIT");
  p.earth_field_initial_gauss = store.get("CAS_MAG_E_INIT");
  p.body_field_initial_gauss = store.get("CAS_MAG_B_INIT");
  p.gps_position_gate = store.get("EKF2_GPS_P_GATE");
  p.gps_velocity_gate = store.get("EKF2_GPS_V_GATE");
  p.baro_gate = store.get("EKF2_BARO_GATE");
  p.mag_gate = store.get("EKF2_MAG_GATE");
  p.gps_delay_s = 1e-3 * store.get("EKF2_GPS_DELAY");
  return p;
}

FlightParams flight_params(const ParamStore& store) {
  FlightParams p;
  p.takeoff_altitude_m = store.get("MIS_TAKEOFF_ALT");
  p.takeoff_speed_m_s = store.get("MPC_TKO_SPEED");
  p.spool_up_s = store.get("COM_SPOOLUP_TIME");
  p.land_speed_m_s = store.get("MPC_LAND_SPEED");
  p.land_tilt_rad = kRadPerDeg * store.get("MPC_TILTMAX_LND");
  p.land_slow_altitude_m = store.get("MPC_LAND_ALT2");
  p.climb_speed_m_s = store.get("MPC_Z_V_AUTO_UP");
  p.descent_speed_m_s = store.get("MPC_Z_V_AUTO_DN");
  p.cruise_speed_m_s = store.get("MPC_XY_CRUISE");
  p.manual_speed_m_s = store.get("MPC_VEL_MANUAL");
  p.manual_tilt_rad = kRadPerDeg * store.get("MPC_MAN_TILT_MAX");
  p.manual_yaw_rate_rad_s = kRadPerDeg * store.get("MPC_MAN_Y_MAX");
  p.stick_deadzone = store.get("MPC_HOLD_DZ");
  p.acceleration_m_s2 = store.get("MPC_ACC_HOR");
  p.acceleration_up_m_s2 = store.get("MPC_ACC_UP_MAX");
  p.acceleration_down_m_s2 = store.get("MPC_ACC_DOWN_MAX");
  p.jerk_m_s3 = store.get("MPC_JERK_AUTO");
  p.yaw_rate_limit_rad_s = kRadPerDeg * store.get("MPC_YAWRAUTO_MAX");
  p.hover_thrust = store.get("MPC_THR_HOVER");
  p.thrust_min = store.get("MPC_THR_MIN");
  p.disarm_after_landing_s = store.get("COM_DISARM_LAND");
  p.disarm_before_flight_s = store.get("COM_DISARM_PRFLT");
  p.offboard_timeout_s = store.get("COM_OF_LOSS_T");
  p.offboard_loss_action = store.get_int("COM_OBL_RC_ACT");
  p.manual_timeout_s = store.get("COM_RC_LOSS_T");
  p.manual_input = store.get_int("COM_RC_IN_MODE");
  p.ground_station_timeout_s = store.get("COM_DL_LOSS_T");
  p.ground_station_loss_action = store.get_int("NAV_DLL_ACT");
  p.manual_loss_action = store.get_int("NAV_RCL_ACT");
  p.battery_action = store.get_int("COM_LOW_BAT_ACT");
  p.tilt_failure_roll_rad = kRadPerDeg * store.get("FD_FAIL_R");
  p.tilt_failure_pitch_rad = kRadPerDeg * store.get("FD_FAIL_P");
  p.tilt_failure_time_s = store.get("FD_FAIL_TTRI");
  p.termination_enabled = store.get_int("CBRK_FLIGHTTERM") != kNoTermination;
  p.arm_without_gps = store.get_int("COM_ARM_WO_GPS") != 0;
  p.battery_low = store.get("BAT_LOW_THR");
  p.battery_critical = store.get("BAT_CRIT_THR");
  p.battery_emergency = store.get("BAT_EMERGEN_THR");
  p.return_altitude_m = store.get("RTL_RETURN_ALT");
  p.return_descend_altitude_m = store.get("RTL_DESCEND_ALT");
  p.return_land_delay_s = store.get("RTL_LAND_DELAY");
  p.acceptance_radius_m = store.get("NAV_ACC_RAD");
  p.acceptance_height_m = store.get("NAV_MC_ALT_RAD");
  p.pattern_shape = store.get_int("CAS_TRJ_SHAPE");
  p.pattern_size_m = store.get("CAS_TRJ_SIZE");
  p.pattern_speed_m_s = store.get("CAS_TRJ_SPEED");
  p.pattern_period_s = store.get("CAS_TRJ_PERIOD");
  return p;
}

HilParams hil_params(const ParamStore& store) {
  return {.stamp_by_arrival = store.get_int("CAS_STAMP_MODE") == 1,
          .answer_by_motor = store.get_int("CAS_HIL_ACT") != 0};
}

}  // namespace cas::fcu
