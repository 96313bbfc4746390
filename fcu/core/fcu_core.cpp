// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/fcu_core.hpp"

#include "base/earth/frames.hpp"

namespace cas::fcu {

void FcuCore::apply_params() {
  if (params_applied == params.revision()) return;
  params_applied = params.revision();
  flight = flight_params(params);
  estimator.set_params(estimator_params(params));
  const ControlParams control = control_params(params);
  if (!cascade.set_params(control)) {
    texts.warn("CAS_ROT_LOST: the other rotors cannot carry the vehicle");
  }
  battery.set_params({params.get("SIM_BAT_DRAIN"), params.get("SIM_BAT_MIN_PCT") / 100,
                      params.get_int("BAT1_N_CELLS")});
}

std::optional<Sticks> FcuCore::sticks(base::RunTime now) const {
  // COM_RC_IN_MODE: 0 radio only, 1 MANUAL_CONTROL only, 2 and 3 either, 4 none.
  const int mode = flight.manual_input;
  const auto fresh = [&](const ManualInput& input) {
    return input.seen && base::to_seconds(now - input.last) < flight.manual_timeout_s;
  };
  if (mode != 0 && mode != 4 && fresh(manual_control)) return manual_control.sticks;
  if (mode != 1 && mode != 4 && fresh(rc_input)) return rc_input.sticks;
  return std::nullopt;
}

TaskContext FcuCore::context(base::RunTime now, double dt) const {
  TaskContext c;
  c.estimate = estimator.state();
  c.yaw_rad = base::euler_rpy(c.estimate.q_ND).z();
  c.position_valid = estimator.position_valid() && estimator.heading_valid();
  c.height_valid = estimator.height_valid();
  c.params = flight;
  c.home_N = home_N;
  c.ground_z = ground_z;
  c.projection = estimator.projection();
  c.sticks = sticks(now);
  c.full_thrust_n = config.vehicle.scales.u1_max_n;
  c.now = now;
  c.dt = dt;
  return c;
}

ArmingInput FcuCore::arming_input(base::RunTime now) const {
  const std::optional<Sticks> pilot = sticks(now);
  return {estimator,
          sensors,
          flight,
          commander.mode(),
          pilot.has_value(),
          pilot ? pilot->throttle : 0.0,
          battery.remaining(),
          now};
}

FailsafeInput FcuCore::failsafe_input(base::RunTime now) const {
  FailsafeInput in;
  const Eigen::Vector3d rpy = base::euler_rpy(estimator.state().q_ND);
  in.roll_rad = rpy.x();
  in.pitch_rad = rpy.y();
  in.position_valid = estimator.position_valid() && estimator.heading_valid();
  in.height_valid = estimator.height_valid();
  in.imu_alive = sensors.alive(SensorHealth::kImu, now);
  in.mag_alive = sensors.alive(SensorHealth::kMag, now);
  in.baro_alive = sensors.alive(SensorHealth::kBaro, now);
  in.gps_alive = sensors.alive(SensorHealth::kGps, now);
  in.ground_station_seen = ground_station_seen;
  in.ground_station_alive =
      base::to_seconds(now - ground_station_last) < flight.ground_station_timeout_s;
  in.sticks_seen = manual_control.seen || rc_input.seen;
  in.sticks_alive = sticks(now).has_value();
  in.battery = battery.remaining();
  return in;
}

void FcuCore::restart_estimate() {
  estimator = Estimator(estimator.params(), config.decimal_year);
  if (config.home_hint) estimator.set_origin(*config.home_hint);
  last_control.reset();
  home_set = false;
  position_resets_seen = 0;
}

void FcuCore::set_home_here() {
  home_N = estimator.state().p_N;
  home_yaw_rad = base::euler_rpy(estimator.state().q_ND).z();
  ground_z = home_N.z();
  home_set = true;
}

}  // namespace cas::fcu
