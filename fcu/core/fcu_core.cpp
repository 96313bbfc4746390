// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/fcu_core.hpp"

#include "base/earth/frames.hpp"

namespace cas::fcu {

void FcuCore::apply_params() {
  if (params_applied == params.revision()) return;
  params_applied = params.revision();
  flight = flight_params(params);
  hil = hil_params(params);
  estimator.set_params(estimator_params(params));
  const ControlParams control = control_params(params);
  if (!cascade.set_params(control)) {
    texts.warn("CAS_ROT_LOST: the other rotors cannot carry the vehicle");
  }
  battery.set_params({params.get("SIM_BAT_DRAIN"), params.get("SIM_BAT_MIN_PCT") / 100,
                      params.get_int("BAT1_N_CELLS")});
}

std::optional<Sticks> PilotInput::sticks(const FlightParams& params, base::RunTime now) const {
  // COM_RC_IN_MODE: 0 radio only, 1 MANUAL_CONTROL only, 2 and 3 either, 4 none.
  const int mode = params.manual_input;
  const auto fresh = [&](const Heard& heard) {
    return heard.at && base::to_seconds(now - *heard.at) < params.manual_timeout_s;
  };
  if (mode != 0 && mode != 4 && fresh(manual_control)) return manual_control.sticks;
  if (mode != 1 && mode != 4 && fresh(radio)) return radio.sticks;
  return std::nullopt;
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
  c.projection = estimator.projection();
  c.sticks = pilot.sticks(flight, now);
  c.full_thrust_n = config.vehicle.scales.u1_max_n;
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
  in.height_valid = estimator.height_valid();
  in.imu_alive = readings.health.alive(SensorHealth::kImu, now);
  in.mag_alive = readings.health.alive(SensorHealth::kMag, now);
  in.baro_alive = readings.health.alive(SensorHealth::kBaro, now);
  in.gps_alive = readings.health.alive(SensorHealth::kGps, now);
  in.gps_frozen = readings.health.gps_frozen();
  in.gps_contradicts_itself = estimator.gps_contradicts_itself();
  in.position_resets = estimator.position_resets();
  in.ground_station_seen = ground_station_heard.has_value();
  in.ground_station_alive = ground_station_heard && base::to_seconds(now - *ground_station_heard) <
                                                        flight.ground_station_timeout_s;
  in.sticks_seen = pilot.seen();
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

void FcuCore::set_home_here() {
  const EstimatorState& state = estimator.state();
  home = {.set = true,
          .p_N = state.p_N,
          .yaw_rad = base::euler_rpy(state.q_ND).z(),
          .ground_z = state.p_N.z()};
}

}  // namespace cas::fcu
