// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/angles.hpp"
#include "fcu/control/control_params.hpp"
#include "fcu/control/wing_params.hpp"
#include "fcu/estimation/estimator_params.hpp"

namespace cas::fcu {

/// Limits and times of the modes and failsafes. Thrusts are shares of full thrust, batteries of
/// full charge; actions, inputs and shapes are numbered as the parameters that they come from.
struct FlightParams {
  double takeoff_altitude_m = 2.5;
  double takeoff_speed_m_s = 1.2;
  double spool_up_s = 1;
  double land_speed_m_s = 0.6;
  double land_slow_altitude_m = 3;
  double land_tilt_rad = 12 * base::kRadPerDeg;
  double climb_speed_m_s = 2;
  double descent_speed_m_s = 1.2;
  double cruise_speed_m_s = 5;
  double manual_speed_m_s = 5;
  double manual_tilt_rad = 35 * base::kRadPerDeg;
  double manual_yaw_rate_rad_s = 120 * base::kRadPerDeg;
  double stick_deadzone = 0.1;
  double acceleration_m_s2 = 3;
  double acceleration_up_m_s2 = 3;
  double acceleration_down_m_s2 = 2;
  double jerk_m_s3 = 8;
  double yaw_rate_limit_rad_s = 60 * base::kRadPerDeg;
  double hover_thrust = 0.5;
  double thrust_min = 0.08;
  double disarm_after_landing_s = 2;
  double disarm_before_flight_s = 10;
  double offboard_timeout_s = 1;
  int offboard_loss_action = 5;
  double manual_timeout_s = 0.5;
  int manual_input = 3;
  double ground_station_timeout_s = 10;
  int ground_station_loss_action = 0;
  int manual_loss_action = 2;
  int battery_action = 3;
  double tilt_failure_roll_rad = 70 * base::kRadPerDeg;
  double tilt_failure_pitch_rad = 70 * base::kRadPerDeg;
  double tilt_failure_time_s = 0.3;
  bool termination_enabled = true;
  bool arm_without_gps = false;
  double battery_low = 0.15, battery_critical = 0.07, battery_emergency = 0.05;
  double return_altitude_m = 15;
  double return_descend_altitude_m = 5;
  double return_land_delay_s = 0;
  double acceptance_radius_m = 1;
  double acceptance_height_m = 0.8;
  int pattern_shape = 0;
  double pattern_size_m = 2;
  double pattern_speed_m_s = 2;
  double pattern_period_s = 10;
};

/// How HIL messages are read and answered.
struct HilParams {
  bool stamp_by_arrival = false;  ///< else by the message's own stamp
  bool answer_by_motor = false;   ///< HIL_ACTUATOR_CONTROLS, else HIL_CONTROLS
};

/// The battery that the controller makes up.
struct BatteryParams {
  double drain_s = 900;       ///< from full to empty while armed
  double floor_percent = 50;  ///< of full, where it stops
  int cells = 4;
};

/// Settings that the parameters control, each with its default. Defaults of an airframe are in
/// default_params().
struct Settings {
  ControlParams control;
  WingParams wing;
  EstimatorParams estimator;
  FlightParams flight;
  HilParams hil;
  BatteryParams battery;
};

}  // namespace cas::fcu
