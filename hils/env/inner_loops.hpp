// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/control/control_cascade.hpp"
#include "fcu/control/rate_controller.hpp"
#include "fcu/estimation/estimator.hpp"
#include "hils/env/step_env.hpp"
#include "libsim/api/messages.hpp"

namespace cas::hils {

/// The controller's loops below the user of a StepEnv, from an action to the autopilot's outputs.
class InnerLoops {
 public:
  /// @param params  of the controller, by name @throws base::ConfigError
  InnerLoops(ActionLevel action_level, const base::Vehicle& vehicle,
             const std::vector<std::pair<std::string, double>>& params);

  /// One control period.
  /// @param gyro_D      rates that the loops read, rad/s
  /// @param in_contact  whether the vehicle touches anything: then a moment does not mean a lost
  ///     rotor
  sim::MotorCommand update(std::span<const double> action, const fcu::EstimatorState& state,
                           const Eigen::Vector3d& gyro_D, bool in_contact, double dt);

 private:
  sim::ActuatorValues motors(std::span<const double> action) const;
  const fcu::MixerResult& follow_rates(std::span<const double> action,
                                       const Eigen::Vector3d& gyro_D, double dt);
  const fcu::MixerResult& follow(const fcu::ControlSetpoint& setpoint,
                                 const fcu::EstimatorState& state, const Eigen::Vector3d& gyro_D,
                                 double dt);
  fcu::ControlSetpoint setpoint(std::span<const double> action, const fcu::EstimatorState& state,
                                bool in_contact);

  ActionLevel level_;
  base::Vehicle vehicle_;
  fcu::ControlCascade cascade_;
  fcu::RateController rates_;  // of ActionLevel::kRates, which has no loop above it
  fcu::MixerResult mixed_;
  bool begun_ = false;
};

}  // namespace cas::hils
