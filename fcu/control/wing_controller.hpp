// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/control/airspeed.hpp"
#include "fcu/control/mixer.hpp"
#include "fcu/control/setpoint.hpp"
#include "fcu/control/surface_allocation.hpp"
#include "fcu/control/total_energy.hpp"
#include "fcu/control/wing_airframe.hpp"
#include "fcu/control/wing_attitude.hpp"
#include "fcu/control/wing_params.hpp"
#include "fcu/estimation/estimator.hpp"

namespace cas::fcu {

/// Flies a wing: setpoint and estimate in, outputs of surfaces and forward rotors out.
///
///   path ------------> L1 --------> roll --+
///   height, airspeed -> total energy       +-> attitude -> rates -> surfaces
///                         |    +-> pitch --+
///                         +------------------------------> throttle
class WingController {
 public:
  /// @param vehicle  with a wing
  explicit WingController(const base::Vehicle& vehicle);

  void set_params(const WingParams& params);
  void reset();
  /// One control step.
  void update(const WingSetpoint& setpoint, const EstimatorState& estimate,
              const Airspeed& airspeed, double dt);
  /// Surfaces neutral, rotors stopped.
  void stop();

  /// By output, -1..1; those of other actuators are 0.
  const std::array<double, base::kMaxOutputs>& outputs() const { return outputs_; }
  OutputKind output_kind(std::size_t output) const { return kinds_[output]; }
  double throttle() const { return throttle_; }
  double roll_setpoint_rad() const { return roll_rad_; }
  double pitch_setpoint_rad() const { return pitch_rad_; }
  const Eigen::Vector3d& rate_setpoint() const { return attitude_.wanted_rates(); }

 private:
  void set_roll(const WingSetpoint& setpoint, const EstimatorState& estimate);
  void set_pitch_and_throttle(const WingSetpoint& setpoint, const EstimatorState& estimate,
                              const Airspeed& airspeed, double dt);
  void put_throttle();

  base::Vehicle vehicle_;
  WingFigures figures_;
  SurfaceAllocation surfaces_;
  std::vector<std::size_t> pushers_;
  std::array<OutputKind, base::kMaxOutputs> kinds_{};
  WingParams params_;
  TotalEnergy energy_;
  WingAttitude attitude_;
  std::array<double, base::kMaxOutputs> outputs_{};
  double roll_rad_ = 0;
  double pitch_rad_ = 0;
  double alpha_rad_ = 0;  // angle of attack that goes with it
  double throttle_ = 0;
};

}  // namespace cas::fcu
