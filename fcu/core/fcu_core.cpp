// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/fcu_core.hpp"

#include "base/earth/frames.hpp"
#include "fcu/params/param_table.hpp"

namespace cas::fcu {

void FcuCore::apply_params() {
  if (params_applied == params.revision()) return;
  params_applied = params.revision();
  const Settings settings = read_settings(params);
  flight = settings.flight;
  wing_params = settings.wing;
  if (wing) wing->set_params(wing_params);
  hil = settings.hil;
  estimator.set_params(settings.estimator);
  if (!cascade.set_params(settings.control)) {
    texts.warn("CAS_ROT_LOST: the other rotors cannot carry the vehicle");
  }
  battery.set_params(settings.battery);
}

TaskContext FcuCore::context(base::RunTime now, double dt) const {
  TaskContext c;
  c.estimate = estimator.state();
  c.yaw_rad = base::euler_rpy(c.estimate.q_ND).z();
  c.position_valid = estimator.position_valid() && estimator.heading_valid();
  c.height_valid = estimator.height_valid();
  c.params = flight;
  c.home_N = home.p_N;
  c.ground_z = home.ground_z;
  c.home_yaw_rad = home.yaw_rad;
  c.projection = estimator.projection();
  c.sticks = pilot.sticks(flight, now);
  c.full_thrust_n = config.vehicle.scales.u1_max_n;
  c.wing = wing_params;
  c.airspeed = readings.airspeed.read(c.estimate.v_N.norm(), wing_params.use_airspeed, now);
  c.now = now;
  c.dt = dt;
  return c;
}

ArmingInput FcuCore::arming_input(base::RunTime now) const {
  const std::optional<Sticks> sticks = pilot.sticks(flight, now);
  return {estimator,
          readings.health,
          flight,
          commander.mode(),
          sticks.has_value(),
          sticks ? sticks->throttle : 0.0,
          battery.remaining(),
          now};
}

FailsafeInput FcuCore::failsafe_input(base::RunTime now) const {
  FailsafeInput in;
  const Eigen::Vector3d rpy = base::euler_rpy(estimator.state().q_ND);
  in.roll_rad = rpy.x();
  in.pitch_rad = rpy.y();
  in.position_valid = estimator.position_valid() && estimator.heading_valid();
  in.mag_alive = readings.health.alive(SensorHealth::kMag, now);
  in.baro_alive = readings.health.alive(SensorHealth::kBaro, now);
  in.gps_frozen = readings.health.gps_frozen();
  in.gps_contradicts_itself = estimator.gps_contradicts_itself();
  in.position_resets = estimator.position_resets();
  in.ground_station_seen = ground_station_heard.has_value();
  in.ground_station_alive = ground_station_heard && base::to_seconds(now - *ground_station_heard) <
                                                        flight.ground_station_timeout_s;
  in.sticks_alive = pilot.sticks(flight, now).has_value();
  in.battery = battery.remaining();
  return in;
}

void FcuCore::restart_estimate() {
  estimator = Estimator(estimator.params(), config.decimal_year);
  if (config.home_hint) estimator.set_origin(*config.home_hint);
  last_control.reset();
  home.set = false;
  position_resets_seen = 0;
}

}  // namespace cas::fcu
