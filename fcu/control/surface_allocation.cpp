// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/surface_allocation.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace cas::fcu {
namespace {

constexpr double kWeak = 0.25;         // of the strongest surface's moment about an axis
constexpr double kLeastCost = 0.02;    // of the largest lift: a surface without lift has a cost too
constexpr double kIndependent = 1e-3;  // of the largest singular value

}  // namespace

SurfaceAllocation::SurfaceAllocation(const base::AeroParams& aero, const WingFigures& figures) {
  for (const base::ControlSurface& surface : aero.surfaces) channels_.push_back(surface.output);
  const Eigen::Matrix3Xd& moment = figures.surface_moment_m3;
  const Eigen::Index count = moment.cols();
  outputs_from_demand_.setZero(count, 3);
  if (count == 0) return;

  Eigen::Matrix3Xd share = moment;
  const Eigen::Vector3d full = figures.full_moment_m3();
  for (int axis = 0; axis < 3; ++axis) share.row(axis) *= full[axis] > 0 ? 1 / full[axis] : 0.0;
  const Eigen::Vector3d strongest = share.cwiseAbs().rowwise().maxCoeff();
  const double most_lift = std::max(figures.surface_lift_m2.maxCoeff(), 1e-12);
  Eigen::VectorXd ease(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const bool strong = (share.col(i).cwiseAbs().array() > kWeak * strongest.array()).any();
    ease[i] = strong ? 1 / (figures.surface_lift_m2[i] / most_lift + kLeastCost) : 0.0;
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> inverse;
  inverse.setThreshold(kIndependent);
  inverse.compute(share * ease.asDiagonal());
  outputs_from_demand_ = ease.asDiagonal() * inverse.pseudoInverse();
}

void SurfaceAllocation::put(const Eigen::Vector3d& demand,
                            std::array<double, base::kMaxOutputs>& outputs) const {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const double value = outputs_from_demand_.row(static_cast<Eigen::Index>(i)).dot(demand);
    outputs[static_cast<std::size_t>(channels_[i])] = std::clamp(value, -1.0, 1.0);
  }
}

}  // namespace cas::fcu
