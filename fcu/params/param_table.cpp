// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/params/param_table.hpp"

#include <optional>
#include <string>
#include <utility>

#include "base/angles.hpp"
#include "fcu/control/loop_design.hpp"
#include "fcu/control/mixer.hpp"
#include "fcu/control/wing_airframe.hpp"

namespace cas::fcu {
namespace {

using base::kRadPerDeg;

/// Goes through the table. Without a store it lists each parameter with the value of its member as
/// default; else it sets the members to the store's values, but those that the store lacks.
class Visitor {
 public:
  explicit Visitor(const ParamStore* store = nullptr) : store_(store) {}

  /// @param unit  the parameter's unit in that of the member
  void real(const std::string& name, double& member, double low, double high, double unit = 1) {
    const auto value = visit(name, ParamType::kReal32, member / unit, low, high);
    if (value) member = unit * *value;
  }
  template <class T>
  void integer(const std::string& name, T& member, int low, int high) {
    const auto value = visit(name, ParamType::kInt32, static_cast<double>(member), low, high);
    if (value) member = static_cast<T>(*value);
  }
  /// A parameter for ground stations, which sets nothing here.
  void shown(const std::string& name, int value, int low, int high) {
    integer(name, value, low, high);
  }

  std::vector<Param> list;

 private:
  std::optional<double> visit(const std::string& name, ParamType type, double initial, double low,
                              double high) {
    if (store_ == nullptr) {
      list.push_back({name, type, initial, initial, initial, low, high});
      return std::nullopt;
    }
    if (!store_->index_of(name)) return std::nullopt;
    return store_->get(name);
  }

  const ParamStore* store_;
};

/// Properties of the vehicle that ground stations see and that select its parameters.
struct Airframe {
  int system_id = 1;
  int mav_type = 2;
  bool spare_rotors = true;  ///< more than four
  bool side_force = true;    ///< rotors are tilted
  AirframeKind kind = AirframeKind::kVtol;
};

// The table. Where PX4 has the same loop or limit, the name and the unit are PX4's.

void visit_rate_loop(Visitor& v, const std::string& axis, const std::string& limit,
                     ControlParams& c, PidGains& gains, int index) {
  const std::string prefix = "MC_" + axis + "RATE_";
  double k = 1;
  v.real(prefix + "P", gains.p, 0, 5);
  v.real(prefix + "I", gains.i, 0, 10);
  v.real(prefix + "D", gains.d, 0, 0.5);
  v.real(prefix + "FF", c.rate_feed_forward[index], 0, 5);
  v.real(prefix + "K", k, 0.01, 5);
  v.real(prefix + "MAX", c.rate_limit_rad_s[index], 0, 1800, kRadPerDeg);
  v.real(limit, gains.i_limit, 0, 1);
  gains.p *= k;
  gains.i *= k;
  gains.d *= k;
}

void visit_attitude(Visitor& v, ControlParams& c) {
  visit_rate_loop(v, "ROLL", "MC_RR_INT_LIM", c, c.rate_roll, 0);
  visit_rate_loop(v, "PITCH", "MC_PR_INT_LIM", c, c.rate_pitch, 1);
  visit_rate_loop(v, "YAW", "MC_YR_INT_LIM", c, c.rate_yaw, 2);
  v.real("MC_ROLL_P", c.roll_p, 0, 20);
  v.real("MC_PITCH_P", c.pitch_p, 0, 20);
  v.real("MC_YAW_P", c.yaw_p, 0, 10);
  v.real("MC_YAW_WEIGHT", c.yaw_weight, 0.05, 1);
  v.real("IMU_GYRO_CUTOFF", c.gyro_cutoff_hz, 0, 1000);
  v.real("IMU_DGYRO_CUTOFF", c.dgyro_cutoff_hz, 0, 1000);
}

void visit_position(Visitor& v, ControlParams& c) {
  v.real("MPC_XY_P", c.xy_p, 0, 5);
  v.real("MPC_Z_P", c.z_p, 0, 5);
  v.real("MPC_XY_VEL_P_ACC", c.xy_velocity.p, 0, 15);
  v.real("MPC_XY_VEL_I_ACC", c.xy_velocity.i, 0, 60);
  v.real("MPC_XY_VEL_D_ACC", c.xy_velocity.d, 0, 5);
  v.real("MPC_Z_VEL_P_ACC", c.z_velocity.p, 0, 15);
  v.real("MPC_Z_VEL_I_ACC", c.z_velocity.i, 0, 60);
  v.real("MPC_Z_VEL_D_ACC", c.z_velocity.d, 0, 5);
  v.real("MPC_XY_VEL_MAX", c.xy_velocity_limit_m_s, 0.5, 30);
  v.real("MPC_Z_VEL_MAX_UP", c.z_velocity_up_limit_m_s, 0.5, 8);
  v.real("MPC_Z_VEL_MAX_DN", c.z_velocity_down_limit_m_s, 0.5, 4);
  v.real("MPC_TILTMAX_AIR", c.tilt_limit_rad, 10, 80, kRadPerDeg);
  v.real("MPC_THR_HOVER", c.hover_thrust, 0.1, 0.9);
  v.real("MPC_THR_MIN", c.thrust_min, 0.02, 0.5);
  v.real("MPC_THR_MAX", c.thrust_max, 0.3, 1);
}

/// Parameters that only vehicles with more than four rotors, or tilted ones, have.
void visit_rotors(Visitor& v, const Airframe& airframe, ControlParams& c) {
  if (airframe.spare_rotors) {
    // Rotors to leave out, 1 for the first, 2 for the second, 4 for the third ...
    v.integer("CAS_ROT_LOST", c.rotors_lost, 0, 65535);
    // Whether to look for rotors that give nothing.
    v.integer("CAS_ROT_DETECT", c.detect_rotor_loss, 0, 1);
  }
  // Share of the force sideways that is used before the vehicle is tilted.
  if (airframe.side_force) v.real("CAS_SIDE_SHARE", c.side_share, 0, 1);
}

/// The estimator's assumptions: figures of the data sheets; axes of D.
void visit_estimator(Visitor& v, EstimatorParams& e) {
  const char* const axes[] = {"X", "Y", "Z"};
  for (int axis = 0; axis < 3; ++axis) {
    // Deviation of one sample: rad/s and m/s^2.
    v.real(std::string("CAS_GYR_NOISE_") + axes[axis], e.gyro_noise_rad_s[axis], 1e-6, 1);
    v.real(std::string("CAS_ACC_NOISE_") + axes[axis], e.accel_noise_m_s2[axis], 1e-5, 20);
  }
  // Random walks, per square root of a second.
  v.real("CAS_GYR_B_WALK", e.gyro_bias_walk_rad_s, 0, 0.1);
  v.real("CAS_ACC_B_WALK", e.accel_bias_walk_m_s2, 0, 1);
  v.real("CAS_MAG_E_WALK", e.earth_field_walk_gauss, 0, 0.1);
  v.real("CAS_MAG_B_WALK", e.body_field_walk_gauss, 0, 0.1);
  v.real("CAS_BARO_WALK", e.baro_offset_walk_m, 0, 1);
  v.real("EKF2_GPS_P_NOISE", e.gps_position_noise_m, 0.001, 10);
  v.real("CAS_GPS_Z_NOISE", e.gps_height_noise_m, 0.001, 20);
  v.real("EKF2_GPS_V_NOISE", e.gps_velocity_noise_m_s, 0.001, 5);
  v.real("EKF2_BARO_NOISE", e.baro_noise_m, 0.001, 15);
  v.real("EKF2_MAG_NOISE", e.mag_noise_gauss, 0.0001, 1);
  v.real("EKF2_GPS_DELAY", e.gps_delay_s, 0, 500, 1e-3);
  v.real("EKF2_GPS_P_GATE", e.gps_position_gate, 1, 20);
  v.real("EKF2_GPS_V_GATE", e.gps_velocity_gate, 1, 20);
  v.real("EKF2_BARO_GATE", e.baro_gate, 1, 20);
  v.real("EKF2_MAG_GATE", e.mag_gate, 1, 20);
  v.real("EKF2_ANGERR_INIT", e.tilt_initial_rad, 0.01, 0.5);
  v.real("EKF2_GBIAS_INIT", e.gyro_bias_initial_rad_s, 0, 0.5);
  v.real("EKF2_ABIAS_INIT", e.accel_bias_initial_m_s2, 0, 2);
  v.real("CAS_MAG_E_INIT", e.earth_field_initial_gauss, 0, 0.2);
  v.real("CAS_MAG_B_INIT", e.body_field_initial_gauss, 0, 0.2);
}

void visit_motion(Visitor& v, FlightParams& f) {
  v.real("MPC_XY_CRUISE", f.cruise_speed_m_s, 0.5, 20);
  v.real("MPC_VEL_MANUAL", f.manual_speed_m_s, 0.5, 20);
  v.real("MPC_Z_V_AUTO_UP", f.climb_speed_m_s, 0.3, 8);
  v.real("MPC_Z_V_AUTO_DN", f.descent_speed_m_s, 0.3, 4);
  v.real("MPC_ACC_HOR", f.acceleration_m_s2, 0.5, 15);
  v.real("MPC_ACC_UP_MAX", f.acceleration_up_m_s2, 0.5, 10);
  v.real("MPC_ACC_DOWN_MAX", f.acceleration_down_m_s2, 0.5, 8);
  v.real("MPC_JERK_AUTO", f.jerk_m_s3, 1, 80);
  v.real("MPC_TKO_SPEED", f.takeoff_speed_m_s, 0.3, 5);
  v.real("MPC_LAND_SPEED", f.land_speed_m_s, 0.1, 3);
  v.real("MPC_LAND_ALT2", f.land_slow_altitude_m, 0, 30);
  v.real("MPC_TILTMAX_LND", f.land_tilt_rad, 10, 80, kRadPerDeg);
  v.real("MPC_MAN_TILT_MAX", f.manual_tilt_rad, 1, 70, kRadPerDeg);
  v.real("MPC_MAN_Y_MAX", f.manual_yaw_rate_rad_s, 0, 400, kRadPerDeg);
  v.real("MPC_HOLD_DZ", f.stick_deadzone, 0, 1);
  v.real("MPC_YAWRAUTO_MAX", f.yaw_rate_limit_rad_s, 0, 360, kRadPerDeg);
  v.real("RTL_RETURN_ALT", f.return_altitude_m, 0, 150);
  v.real("RTL_DESCEND_ALT", f.return_descend_altitude_m, 0, 100);
  v.real("RTL_LAND_DELAY", f.return_land_delay_s, -1, 300);
  v.real("MIS_TAKEOFF_ALT", f.takeoff_altitude_m, 0, 80);
  v.real("NAV_ACC_RAD", f.acceptance_radius_m, 0.05, 200);
  v.real("NAV_MC_ALT_RAD", f.acceptance_height_m, 0.05, 200);
  // Built-in pattern flown in Hold: 0 none, 1 circle, 2 figure eight, 3 steps.
  v.integer("CAS_TRJ_SHAPE", f.pattern_shape, 0, 3);
  v.real("CAS_TRJ_SIZE", f.pattern_size_m, 0.1, 50);
  v.real("CAS_TRJ_SPEED", f.pattern_speed_m_s, 0.1, 10);
  v.real("CAS_TRJ_PERIOD", f.pattern_period_s, 1, 120);
}

void visit_wing_rate(Visitor& v, const std::string& letter, WingParams& w, PidGains& gains,
                     int index) {
  const std::string prefix = "FW_" + letter + "R_";
  v.real(prefix + "P", gains.p, 0, 10);
  v.real(prefix + "I", gains.i, 0, 10);
  v.real(prefix + "FF", w.rate_feed_forward[index], 0, 10);
  v.real(prefix + "IMAX", gains.i_limit, 0, 1);
}

void visit_wing_attitude(Visitor& v, WingParams& w) {
  visit_wing_rate(v, "R", w, w.roll_rate, 0);
  visit_wing_rate(v, "P", w, w.pitch_rate, 1);
  visit_wing_rate(v, "Y", w, w.yaw_rate, 2);
  v.real("FW_R_TC", w.roll_time_s, 0.2, 1);
  v.real("FW_P_TC", w.pitch_time_s, 0.2, 1);
  v.real("FW_R_RMAX", w.rate_limit_rad_s[0], 0, 180, kRadPerDeg);
  v.real("FW_P_RMAX_POS", w.rate_limit_rad_s[1], 0, 180, kRadPerDeg);
  v.real("FW_Y_RMAX", w.rate_limit_rad_s[2], 0, 180, kRadPerDeg);
  v.real("FW_R_LIM", w.roll_limit_rad, 10, 65, kRadPerDeg);
  v.real("FW_P_LIM_MAX", w.pitch_max_rad, 0, 60, kRadPerDeg);
  v.real("FW_P_LIM_MIN", w.pitch_min_rad, -60, 0, kRadPerDeg);
  v.real("FW_PSP_OFF", w.pitch_offset_rad, -30, 30, kRadPerDeg);
}

/// Throttles are shares of the static thrust, airspeeds equivalent ones.
void visit_wing_energy(Visitor& v, WingParams& w) {
  v.integer("FW_USE_AIRSPD", w.use_airspeed, 0, 1);
  v.real("FW_AIRSPD_MIN", w.airspeed_min_m_s, 3, 100);
  v.real("FW_AIRSPD_TRIM", w.airspeed_trim_m_s, 3, 100);
  v.real("FW_AIRSPD_MAX", w.airspeed_max_m_s, 3, 150);
  v.real("FW_THR_MIN", w.throttle_min, 0, 1);
  v.real("FW_THR_TRIM", w.throttle_trim, 0, 1);
  v.real("FW_THR_MAX", w.throttle_max, 0, 1);
  v.real("FW_T_CLMB_MAX", w.climb_max_m_s, 0.5, 30);
  v.real("FW_T_SINK_MIN", w.sink_min_m_s, 0.5, 30);
  v.real("FW_T_SINK_MAX", w.sink_max_m_s, 0.5, 30);
  v.real("FW_T_ALT_TC", w.height_time_s, 1, 30);
  v.real("FW_T_TAS_TC", w.airspeed_time_s, 1, 30);
  v.real("FW_T_THR_DAMPING", w.throttle_damping, 0, 2);
  v.real("FW_T_THR_INTEG", w.throttle_integrator, 0, 2);
  v.real("FW_T_PTCH_DAMP", w.pitch_damping, 0, 2);
  v.real("FW_T_I_GAIN_PIT", w.pitch_integrator, 0, 2);
  v.real("FW_T_SPDWEIGHT", w.speed_weight, 0, 2);
}

void visit_wing_way(Visitor& v, WingParams& w) {
  v.real("FW_L1_PERIOD", w.path_period_s, 4, 100);
  v.real("FW_L1_DAMPING", w.path_damping, 0.6, 0.9);
  v.real("NAV_LOITER_RAD", w.loiter_radius_m, 5, 1000);
  v.real("RWTO_MAX_THR", w.runway_throttle, 0, 1);
  v.real("RWTO_RAMP_TIME", w.runway_ramp_s, 0, 15);
  v.real("RWTO_PSP", w.runway_pitch_rad, -10, 20, kRadPerDeg);
  v.real("FW_LND_ANG", w.land_slope_rad, 1, 15, kRadPerDeg);
  v.real("FW_LND_AIRSPD", w.land_airspeed_m_s, 3, 100);
  v.real("FW_LND_FLALT", w.flare_height_m, 0.1, 20);
  v.real("FW_LND_FL_SINK", w.flare_sink_m_s, 0.1, 2);
}

void visit_vtol(Visitor& v, WingParams& w) {
  v.real("VT_ARSP_TRANS", w.transition_airspeed_m_s, 1, 100);
  v.real("VT_ARSP_BLEND", w.blend_airspeed_m_s, 0, 100);
  v.real("VT_F_TRANS_THR", w.transition_throttle, 0, 1);
  v.real("VT_TRANS_TIMEOUT", w.transition_timeout_s, 0.1, 60);
  v.real("VT_B_TRANS_DUR", w.back_transition_s, 0.1, 60);
}

/// Parameters that only vehicles with a wing have.
void visit_wing(Visitor& v, AirframeKind kind, WingParams& w) {
  if (kind == AirframeKind::kMulticopter) return;
  visit_wing_attitude(v, w);
  visit_wing_energy(v, w);
  visit_wing_way(v, w);
  if (kind == AirframeKind::kVtol) visit_vtol(v, w);
}

void visit_safety(Visitor& v, FlightParams& f) {
  constexpr int kNoTermination = 121212;  // PX4's circuit breaker value
  int breaker = f.termination_enabled ? 0 : kNoTermination;
  v.integer("COM_ARM_WO_GPS", f.arm_without_gps, 0, 1);
  v.real("COM_DISARM_LAND", f.disarm_after_landing_s, -1, 20);
  v.real("COM_DISARM_PRFLT", f.disarm_before_flight_s, -1, 60);
  v.real("COM_SPOOLUP_TIME", f.spool_up_s, 0, 5);
  v.real("COM_OF_LOSS_T", f.offboard_timeout_s, 0, 60);
  v.integer("COM_OBL_RC_ACT", f.offboard_loss_action, 0, 7);
  v.real("COM_RC_LOSS_T", f.manual_timeout_s, 0.1, 35);
  v.integer("COM_RC_IN_MODE", f.manual_input, 0, 4);
  v.integer("COM_DL_LOSS_T", f.ground_station_timeout_s, 5, 300);
  v.integer("COM_LOW_BAT_ACT", f.battery_action, 0, 3);
  v.integer("NAV_DLL_ACT", f.ground_station_loss_action, 0, 6);
  v.integer("NAV_RCL_ACT", f.manual_loss_action, 0, 6);
  v.real("FD_FAIL_R", f.tilt_failure_roll_rad, 60, 180, kRadPerDeg);
  v.real("FD_FAIL_P", f.tilt_failure_pitch_rad, 60, 180, kRadPerDeg);
  v.real("FD_FAIL_TTRI", f.tilt_failure_time_s, 0.02, 5);
  v.integer("CBRK_FLIGHTTERM", breaker, 0, kNoTermination);
  v.real("BAT_LOW_THR", f.battery_low, 0, 1);
  v.real("BAT_CRIT_THR", f.battery_critical, 0, 1);
  v.real("BAT_EMERGEN_THR", f.battery_emergency, 0, 1);
  f.termination_enabled = breaker != kNoTermination;
}

void visit_system(Visitor& v, const Airframe& airframe, HilParams& h, BatteryParams& b) {
  v.integer("BAT1_N_CELLS", b.cells, 1, 16);
  v.real("SIM_BAT_DRAIN", b.drain_s, 1, 86400);
  v.real("SIM_BAT_MIN_PCT", b.floor_percent, 0, 100);
  // The message that carries the answer: 0 HIL_CONTROLS (U1..U4), 1 HIL_ACTUATOR_CONTROLS (motors).
  v.integer("CAS_HIL_ACT", h.answer_by_motor, 0, 1);
  // Time of a sensor message: 0 its own stamp, 1 its arrival.
  v.integer("CAS_STAMP_MODE", h.stamp_by_arrival, 0, 1);
  v.shown("MAV_SYS_ID", airframe.system_id, 1, 250);
  v.shown("MAV_COMP_ID", 1, 1, 250);
  v.shown("MAV_TYPE", airframe.mav_type, 0, 50);
  v.shown("SYS_AUTOSTART", 10016, 0, 9999999);
  v.shown("SYS_HITL", 1, 0, 2);
  // Nonzero: a sensor is there and calibrated, as ground stations read it.
  v.shown("CAL_GYRO0_ID", 1310988, 0, 2147483647);
  v.shown("CAL_ACC0_ID", 1310988, 0, 2147483647);
  v.shown("CAL_MAG0_ID", 197388, 0, 2147483647);
  v.shown("CAL_BARO0_ID", 6620172, 0, 2147483647);
}

void visit_params(Visitor& v, const Airframe& airframe, Settings& s) {
  visit_attitude(v, s.control);
  visit_position(v, s.control);
  visit_rotors(v, airframe, s.control);
  visit_estimator(v, s.estimator);
  visit_motion(v, s.flight);
  visit_wing(v, airframe.kind, s.wing);
  visit_safety(v, s.flight);
  visit_system(v, airframe, s.hil, s.battery);
}

// Defaults.

/// MAV_TYPE of a plane, or by the number of rotors that lift.
int vehicle_type(AirframeKind kind, int rotors) {
  constexpr int kFixedWing = 1;
  constexpr int kVtolFixedRotor = 22;
  if (kind == AirframeKind::kPlane) return kFixedWing;
  if (kind == AirframeKind::kVtol) return kVtolFixedRotor;
  constexpr int kGenericMultirotor = 43;
  constexpr std::pair<int, int> kTypes[] = {{3, 15}, {4, 2}, {6, 13}, {8, 14}, {10, 35}, {12, 29}};
  for (const auto& [count, type] : kTypes) {
    if (count == rotors) return type;
  }
  return kGenericMultirotor;
}

}  // namespace

std::vector<Param> default_params(const base::Vehicle& whole, const EstimatorParams& figures,
                                  double delay_s) {
  Settings defaults;
  const base::Vehicle vehicle = lifting_part(whole);
  const AirframeKind kind = airframe_kind(whole);
  if (kind != AirframeKind::kMulticopter) derive_wing(whole, defaults.wing);
  defaults.estimator = figures;
  // A vehicle that tilts slowly cannot follow a quick change of acceleration.
  const double share =
      vehicle.rotors.empty() ? 1.0 : derive_gains(vehicle, delay_s, defaults.control);
  defaults.flight.jerk_m_s3 *= share;
  defaults.flight.acceleration_m_s2 *= share;
  Visitor lister;
  visit_params(lister,
               {.system_id = vehicle.system_id,
                .mav_type = vehicle_type(kind, vehicle.rotor_count()),
                .spare_rotors = vehicle.rotor_count() > 4,
                .side_force = Mixer(vehicle).side_force_n() > 0,
                .kind = kind},
               defaults);
  return std::move(lister.list);
}

Settings read_settings(const ParamStore& store) {
  Settings settings;
  Visitor reader(&store);
  visit_params(reader, {}, settings);
  settings.flight.hover_thrust = settings.control.hover_thrust;
  settings.flight.thrust_min = settings.control.thrust_min;
  // HIL_CONTROLS has U1..U4 only, and the simulator makes speeds of all rotors of them.
  if (!settings.hil.answer_by_motor) {
    settings.control.rotors_lost = 0;
    settings.control.detect_rotor_loss = false;
    settings.control.side_share = 0;
  }
  return settings;
}

}  // namespace cas::fcu
