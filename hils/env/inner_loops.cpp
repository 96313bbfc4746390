// SPDX-License-Identifier: BSD-3-Clause
#include "hils/env/inner_loops.hpp"

#include <algorithm>

#include "base/earth/frames.hpp"
#include "base/error.hpp"
#include "fcu/params/param_table.hpp"
#include "fcu/params/params.hpp"

namespace cas::hils {

using Eigen::Vector3d;
using Eigen::Vector4d;

InnerLoops::InnerLoops(ActionLevel action_level, const base::Vehicle& vehicle,
                       const std::vector<std::pair<std::string, double>>& params)
    : level_(action_level), vehicle_(vehicle), cascade_(vehicle) {
  fcu::ParamStore store(vehicle);
  for (const auto& [name, value] : params) {
    const fcu::ParamSetResult result = store.set(name, value);
    if (result == fcu::ParamSetResult::kUnknown) throw base::ConfigError("no parameter " + name);
    if (result != fcu::ParamSetResult::kOk) {
      throw base::ConfigError("parameter " + name + " is out of range");
    }
  }
  // As the emulated controller answers: per motor where Eq. (3) is not the vehicle's.
  store.set("CAS_HIL_ACT", fcu::Mixer::is_eq3(vehicle) ? 0 : 1);
  const fcu::ControlParams control = fcu::read_settings(store).control;
  cascade_.set_params(control);
  rates_.set_params(control);
}

sim::MotorCommand InnerLoops::update(std::span<const double> action,
                                     const fcu::EstimatorState& state, const Vector3d& gyro_D,
                                     bool in_contact, double dt) {
  sim::MotorCommand command{.sensor_time = state.time,
                            .kind = sim::MotorCommand::Kind::kMotorOutputs,
                            .armed = true,
                            .values = {}};
  if (level_ == ActionLevel::kMotors) {
    command.values = motors(action);
    return command;
  }
  const fcu::MixerResult& result =
      level_ == ActionLevel::kRates
          ? follow_rates(action, gyro_D, dt)
          : follow(setpoint(action, state, in_contact), state, gyro_D, dt);
  const auto outputs = cascade_.mixer().outputs(result);
  command.values = sim::ActuatorValues::Map(outputs.data(), std::ssize(outputs));
  return command;
}

/// First the motors, then the servos, each in the order of the vehicle file.
sim::ActuatorValues InnerLoops::motors(std::span<const double> action) const {
  sim::ActuatorValues values = sim::ActuatorValues::Zero(base::kMaxOutputs);
  std::size_t next = 0;
  for (const base::Rotor& rotor : vehicle_.rotors) values[rotor.output] = action[next++];
  for (const base::Rotor& rotor : vehicle_.rotors) {
    if (rotor.tilt) values[rotor.tilt->output] = action[next++];
  }
  return values;
}

const fcu::MixerResult& InnerLoops::follow_rates(std::span<const double> action,
                                                 const Vector3d& gyro_D, double dt) {
  const base::ControlScales& full = vehicle_.scales;
  rates_.on_rates(gyro_D, dt);
  const Vector3d torque = rates_.update({action[0], action[1], action[2]}, mixed_.torque, dt);
  Vector4d demand;
  demand << std::clamp(action[3], 0.0, 1.0) * full.u1_max_n,
      torque.cwiseProduct(Vector3d(full.u2_max_nm, full.u3_max_nm, full.u4_max_nm));
  mixed_ = cascade_.mixer().mix(demand);
  return mixed_;
}

const fcu::MixerResult& InnerLoops::follow(const fcu::ControlSetpoint& setpoint,
                                           const fcu::EstimatorState& state, const Vector3d& gyro_D,
                                           double dt) {
  cascade_.on_rates(gyro_D, dt);
  return cascade_.update(setpoint, state, dt);
}

fcu::ControlSetpoint InnerLoops::setpoint(std::span<const double> action,
                                          const fcu::EstimatorState& state, bool in_contact) {
  fcu::ControlSetpoint setpoint;
  setpoint.may_touch = in_contact;
  if (level_ == ActionLevel::kAttitude) {
    setpoint.attitude = fcu::AttitudeSetpoint{
        .q_ND = base::quaternion_rpy(action[0], action[1], action[2]),
        .yaw_rate_rad_s = 0,
        .thrust_n = std::clamp(action[3], 0.0, 1.0) * vehicle_.scales.u1_max_n};
    return setpoint;
  }
  setpoint.trajectory.emplace();
  setpoint.trajectory->v_N = {action[0], action[1], action[2]};
  setpoint.trajectory->yaw_rate_rad_s = action[3];
  // The heading that is turned from here is the one it has at the start.
  if (!begun_) setpoint.trajectory->yaw_rad = base::euler_rpy(state.q_ND).z();
  begun_ = true;
  return setpoint;
}

}  // namespace cas::hils
