// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/rotor_loss.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cas::fcu {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

constexpr double kObserver_per_s = 20;  // K: 50 ms, some times the rotors' lag
constexpr double kLong_s = 1e3;         // after this time a servo has reached its command
constexpr double kSlow_s = 4;           // of wind and centre of gravity
constexpr double kSettle_s = 0.5;       // after a start, before anything is believed
constexpr double kHold_s = 0.15;        // for so long it must look lost
constexpr double kLeastShare = 0.65;    // of the rotor's moment that is missing
constexpr double kMostShare = 1.5;
constexpr double kLeastLikeness = 0.8;  // squared cosine between missing moment and rotor's
constexpr double kSlowest = 0.05;   // share of full omega^2 below which a rotor is not looked at
constexpr double kYawWeight = 0.5;  // yaw is disturbed most: by spin-up and air

/// The tilt nearest to `tilt_rad` that a rotor's servo reaches; 0 without one.
double within(const base::Rotor& rotor, double tilt_rad) {
  return rotor.tilt ? std::clamp(tilt_rad, rotor.tilt->min_rad, rotor.tilt->max_rad) : 0.0;
}

}  // namespace

RotorLossDetector::RotorLossDetector(const base::Vehicle& vehicle)
    : vehicle_(vehicle), apart_(vehicle), tilt_rad_(vehicle.rotors.size(), 0.0) {
  Vector3d size = Vector3d::Zero();
  for (base::Rotor& rotor : apart_.rotors) {
    rotor.wake.reset();
    has_servos_ = has_servos_ || rotor.tilt;
  }
  // Scale for moments: the largest that the rotors give at any tilt of the servos.
  for (const double end : {-M_PI, M_PI, 0.0}) {
    for (std::size_t i = 0; i < tilt_rad_.size(); ++i)
      tilt_rad_[i] = within(vehicle.rotors[i], end);
    take_axes();
    size = size.cwiseMax(moment_D_.rowwise().norm());
  }
  const Index rotors = vehicle.rotor_count();
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
  for (int axis = 0; axis < 3; ++axis) weight_[axis] = size[axis] > 0 ? 1 / size[axis] : 0.0;
  weight_[2] *= kYawWeight;
}

/// Moments of the rotors with their axes as they are tilted now.
void RotorLossDetector::take_axes() {
  const base::Effectiveness wrench_B = vehicle_.effectiveness(tilt_rad_);
  moment_D_.resize(3, wrench_B.cols());
  moment_D_ << wrench_B.row(3), -wrench_B.row(4), -wrench_B.row(5);
  loss_D_ = moment_D_;
  const base::Effectiveness gain_B = apart_.effectiveness(tilt_rad_) - wrench_B;
  for (Index i = 0; i < moment_D_.cols(); ++i) {
    const auto& wake = vehicle_.rotors[static_cast<std::size_t>(i)].wake;
    if (!wake) continue;
    loss_D_.col(static_cast<Index>(wake->upper)) -=
        Vector3d(gain_B(3, i), -gain_B(4, i), -gain_B(5, i));
  }
}

std::optional<int> RotorLossDetector::update(const Vector3d& w_D, const MixerResult& asked,
                                             RotorSet lost, double dt) {
  if (dt <= 0 || !w_D.allFinite() || asked.omega_sq.size() != omega_.size()) return std::nullopt;
  if (!started_) {
    started_ = true;
    omega_ = asked.omega_sq.cwiseSqrt();
    follow_tilts(asked.tilt_rad, kLong_s);
    momentum_start_ = vehicle_.inertia_kg_m2.cwiseProduct(w_D);
    integral_.setZero();
    residual_D_.setZero();
    slow_D_.setZero();
    quiet_s_ = suspected_s_ = 0;
    suspect_ = -1;
    return std::nullopt;
  }
  observe(w_D, dt);
  follow_speeds(asked.omega_sq, dt);
  follow_tilts(asked.tilt_rad, dt);
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
  const Vector3d momentum = vehicle_.inertia_kg_m2.cwiseProduct(w_D);
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

void RotorLossDetector::follow_tilts(const base::RotorVector& tilt_rad, double dt) {
  if (!has_servos_) return;
  for (std::size_t i = 0; i < tilt_rad_.size(); ++i) {
    const auto index = static_cast<Index>(i);
    const auto& servo = vehicle_.rotors[i].tilt;
    if (!servo || index >= tilt_rad.size()) continue;
    const double time = servo->time_constant_s;
    const double step = (within(vehicle_.rotors[i], tilt_rad[index]) - tilt_rad_[i]) *
                        (time > 0 ? 1 - std::exp(-dt / time) : 1.0);
    tilt_rad_[i] += std::clamp(step, -servo->rate_rad_s * dt, servo->rate_rad_s * dt);
  }
  take_axes();
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
