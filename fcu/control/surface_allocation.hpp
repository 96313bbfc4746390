// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/control/wing_airframe.hpp"

namespace cas::fcu {

/// Outputs of the control surfaces for moments about Dx, Dy, Dz, from the coefficients in the
/// vehicle file: the weighted pseudo-inverse of their effects. A surface costs by the square of its
/// lift, so that a tailplane pitches the vehicle rather than both ailerons, and a surface that is
/// weak about each axis (a flap) stays where it is.
class SurfaceAllocation {
 public:
  SurfaceAllocation() = default;
  SurfaceAllocation(const base::AeroParams& aero, const WingFigures& figures);

  /// Sets the outputs of the surfaces, -1..1.
  /// @param demand  shares of the moments of full deflection, about Dx, Dy, Dz
  void put(const Eigen::Vector3d& demand, std::array<double, base::kMaxOutputs>& outputs) const;
  /// Outputs that surfaces have.
  const std::vector<int>& channels() const { return channels_; }

 private:
  Eigen::MatrixX3d outputs_from_demand_;
  std::vector<int> channels_;
};

}  // namespace cas::fcu
