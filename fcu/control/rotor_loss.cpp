// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/rotor_loss.hpp"

#include <algorithm>
#include <cmath>

namespace cas::fcu {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

constexpr double kObserver_per_s = 20;  // K: 50 ms, some times the rotors' lag
constexpr double kSlow_s = 4;           // of wind and centre of gravity
constexpr double kSettle_s = 0.5;       // after a start, before anything is believed
constexpr double kHold_s = 0.15;        // for so long it must look lost
constexpr double kLeastShare = 0.65;    // of the rotor's moment that is missing
constexpr double kMostShare = 1.5;
constexpr double kLeastLikeness = 0.8;  // squared cosine between missing moment and rotor's
constexpr double kSlowest = 0.05;   // share of full omega^2 below which a rotor is not looked at
constexpr double kYawWeight = 0.5;  // yaw is disturbed most: by spin-up and air

}  // namespace

RotorLossDetector::RotorLossDetector(const base::Vehicle& vehicle)
    : inertia_kg_m2_(vehicle.inertia_kg_m2) {
  const base::Effectiveness wrench_B = vehicle.effectiveness();
  const Index rotors = vehicle.rotor_count();
  moment_D_.resize(3, rotors);
  moment_D_.row(0) = wrench_B.row(3);
  moment_D_.row(1) = -wrench_B.row(4);
  moment_D_.row(2) = -wrench_B.row(5);
  loss_D_ = moment_D_;
  base::Vehicle apart = vehicle;
  for (base::Rotor& rotor : apart.rotors) rotor.wake.reset();
  const base::Effectiveness apart_B = apart.effectiveness();
  for (Eigen::Index i = 0; i < moment_D_.cols(); ++i) {
    const auto& wake = vehicle.rotors[static_cast<std::size_t>(i)].wake;
    if (!wake) continue;
    const Eigen::Matrix<double, 6, 1> gain = apart_B.col(i) - wrench_B.col(i);
    loss_D_.col(static_cast<Eigen::Index>(wake->upper)) -=
        Eigen::Vector3d(gain[3], -gain[4], -gain[5]);
  }
  up_s_.resize(rotors);
  down_s_.resize(rotors);
  high_.resize(rotors);
  omega_.setZero(rotors);
  for (Index i = 0; i < rotors; ++i) {
    const base::RotorParams& params = vehicle.rotors[static_cast<std::size_t>(i)].params;
    up_s_[i] = params.time_constant_up_s;
    down_s_[i] = params.time_constant_down_s;
    high_[i] = std::pow(params.omega_max_rad_s, 2);
  }
  const Vector3d size = moment_D_.rowwise().norm();
  for (int axis = 0; axis < 3; ++axis) weight_[axis] = size[axis] > 0 ? 1 / size[axis] : 0.0;
  weight_[2] *= kYawWeight;
}

std::optional<int> RotorLossDetector::update(const Vector3d& w_D, const base::RotorVector& omega_sq,
                                             RotorSet lost, double dt) {
  if (dt <= 0 || !w_D.allFinite() || omega_sq.size() != omega_.size()) return std::nullopt;
  if (!started_) {
    started_ = true;
    omega_ = omega_sq.cwiseSqrt();
    momentum_start_ = inertia_kg_m2_.cwiseProduct(w_D);
    integral_.setZero();
    residual_D_.setZero();
    slow_D_.setZero();
    quiet_s_ = suspected_s_ = 0;
    suspect_ = -1;
    return std::nullopt;
  }
  observe(w_D, dt);
  follow_speeds(omega_sq, dt);
  quiet_s_ += dt;
  const int rotor = quiet_s_ > kSettle_s ? suspect(lost) : -1;
  suspected_s_ = rotor == suspect_ && rotor >= 0 ? suspected_s_ + dt : 0.0;
  suspect_ = rotor;
  if (suspected_s_ < kHold_s) return std::nullopt;
  suspected_s_ = 0;
  return rotor;
}

/// The residual after the step that the speeds of `omega_` were turned in.
void RotorLossDetector::observe(const Vector3d& w_D, double dt) {
  const Vector3d momentum = inertia_kg_m2_.cwiseProduct(w_D);
  const Vector3d asked = moment_D_ * omega_.cwiseAbs2();
  integral_ += (asked - w_D.cross(momentum) + residual_D_) * dt;
  residual_D_ = kObserver_per_s * (momentum - momentum_start_ - integral_);
  // The first second has no slow part yet: it takes all there is.
  const double time = std::min(kSlow_s, quiet_s_ + dt);
  slow_D_ += std::min(1.0, dt / time) * (residual_D_ - slow_D_);
}

void RotorLossDetector::follow_speeds(const base::RotorVector& omega_sq, double dt) {
  for (Index i = 0; i < omega_.size(); ++i) {
    const double target = std::sqrt(std::max(omega_sq[i], 0.0));
    const double time = target > omega_[i] ? up_s_[i] : down_s_[i];
    omega_[i] += (target - omega_[i]) * (time > 0 ? 1 - std::exp(-dt / time) : 1.0);
  }
}

/// The rotor whose loss explains the residual, or -1.
int RotorLossDetector::suspect(RotorSet lost) const {
  const Vector3d missing = weight_.cwiseProduct(residual_D());
  int best = -1;
  double best_likeness = kLeastLikeness;
  for (Index i = 0; i < omega_.size(); ++i) {
    const double omega_sq = omega_[i] * omega_[i];
    if (has(lost, static_cast<int>(i)) || omega_sq < kSlowest * high_[i]) continue;
    const Vector3d own = -weight_.cwiseProduct(loss_D_.col(i)) * omega_sq;
    const double along = own.dot(missing);
    const double share = along / own.squaredNorm();
    if (share < kLeastShare || share > kMostShare) continue;
    const double likeness = along * along / (own.squaredNorm() * missing.squaredNorm());
    if (likeness <= best_likeness) continue;
    best = static_cast<int>(i);
    best_likeness = likeness;
  }
  return best;
}

}  // namespace cas::fcu
