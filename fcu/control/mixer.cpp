// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/mixer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/earth/gravity.hpp"
#include "base/error.hpp"

namespace cas::fcu {

using Eigen::Vector2d;
using Eigen::Vector4d;

namespace {

bool is_equal(const base::RotorParams& a, const base::RotorParams& b) {
  return a.thrust_coefficient == b.thrust_coefficient &&
         a.torque_coefficient == b.torque_coefficient && a.omega_max_rad_s == b.omega_max_rad_s &&
         a.omega_idle_rad_s == b.omega_idle_rad_s;
}

/// Thrusts U1 that keep base + column U1 within [low, high] for every rotor.
struct ThrustRange {
  double from = 0;
  double to = 0;
};

ThrustRange thrust_range(const Vector4d& column, const Vector4d& base, double low, double high) {
  const Vector4d from = (Vector4d::Constant(low) - base).cwiseQuotient(column);
  const Vector4d to = (Vector4d::Constant(high) - base).cwiseQuotient(column);
  return {from.maxCoeff(), to.minCoeff()};
}

/// Largest part 0..1 of `step` that can be added to `base` within [low, high].
double largest_part(const Vector4d& base, const Vector4d& step, double low, double high) {
  double part = 1;
  for (int i = 0; i < 4; ++i) {
    if (step[i] > 0) part = std::min(part, (high - base[i]) / step[i]);
    if (step[i] < 0) part = std::min(part, (low - base[i]) / step[i]);
  }
  return std::clamp(part, 0.0, 1.0);
}

double heading_torque_of(const ControlAllocation& allocation, double hover_n) {
  constexpr double kAlike = 0.25;     // of the other sense
  constexpr double kNothing = 0.005;  // by chance
  const auto [less_nm, more_nm] = allocation.yaw_reach(hover_n);
  if (less_nm <= kNothing * more_nm) return 0;
  return less_nm < kAlike * more_nm ? less_nm : std::numeric_limits<double>::infinity();
}

}  // namespace

bool Mixer::is_eq3(const base::Vehicle& vehicle) {
  if (vehicle.rotor_count() != 4) return false;
  const base::RotorParams& first = vehicle.rotors.front().params;
  return std::all_of(vehicle.rotors.begin(), vehicle.rotors.end(), [&](const base::Rotor& rotor) {
    return rotor.axis_B == Eigen::Vector3d::UnitZ() && !rotor.wake && !rotor.tilt &&
           is_equal(rotor.params, first);
  });
}

Mixer::Mixer(const base::Vehicle& vehicle)
    : vehicle_(vehicle), hover_n_(vehicle.mass_kg * base::kStandardGravity_m_s2) {
  for (const base::Rotor& rotor : vehicle_.rotors) {
    kinds_[static_cast<std::size_t>(rotor.output)] = OutputKind::kMotor;
    if (rotor.tilt) kinds_[static_cast<std::size_t>(rotor.tilt->output)] = OutputKind::kServo;
  }
  if (vehicle.rotors.empty()) return;  // a plane: its rotor does not lift
  if (is_eq3(vehicle)) {
    u_from_omega_sq_ = vehicle.mixing_matrix();
    omega_sq_from_u_ = u_from_omega_sq_.inverse();
    low_ = std::pow(vehicle_.rotors.front().params.omega_idle_rad_s, 2);
    high_ = std::pow(vehicle_.rotors.front().params.omega_max_rad_s, 2);
    return;
  }
  allocation_.emplace(AllocationSetup::of(vehicle));
  if (allocation_->rank() < 3) {
    throw base::ConfigError("vehicle '" + vehicle.name +
                            "': its rotors cannot give thrust, roll and pitch independently");
  }
  side_force_n_ = allocation_->side_force_n(hover_n_);
  heading_torque_nm_ = heading_torque_of(*allocation_, hover_n_);
}

MixerResult Mixer::mix(const Vector4d& demand, bool may_lift, const Vector2d& side_D_n) const {
  if (vehicle_.rotors.empty()) return {};
  return allocation_ ? allocation_->allocate({demand, side_D_n}, may_lift)
                     : mix_eq3(demand, may_lift);
}

MixerResult Mixer::mix_eq3(const Vector4d& demand, bool may_lift) const {
  const Vector4d thrust_column = omega_sq_from_u_.col(0);

  // Roll and pitch, scaled only when no thrust makes room for them.
  Vector4d tilt = omega_sq_from_u_.col(1) * demand[1] + omega_sq_from_u_.col(2) * demand[2];
  ThrustRange range = thrust_range(thrust_column, tilt, low_, high_);
  if (!may_lift && range.from > demand[0]) {
    const Vector4d level = thrust_column * std::max(demand[0], idle_eq3()[0]);
    tilt *= largest_part(level, tilt, low_, high_);
    range = thrust_range(thrust_column, tilt, low_, high_);
    range.to = std::max(range.from, range.to);
  } else if (range.from > range.to) {
    const ThrustRange level = thrust_range(thrust_column, Vector4d::Zero(), low_, high_);
    // The width of the range shrinks linearly with the scale: from `level` to `range`.
    const double width_level = level.to - level.from;
    const double width = range.to - range.from;
    const double scale = std::clamp(width_level / (width_level - width), 0.0, 1.0);
    tilt *= scale;
    range = thrust_range(thrust_column, tilt, low_, high_);
    range.to = std::max(range.from, range.to);
  }

  // Thrust as near as possible, then the part of yaw that fits.
  const double thrust = std::clamp(demand[0], range.from, range.to);
  const Vector4d base = tilt + thrust_column * thrust;
  const Vector4d turn = omega_sq_from_u_.col(3) * demand[3];
  const Vector4d omega_sq = base + turn * largest_part(base, turn, low_, high_);

  MixerResult result;
  const Vector4d within = omega_sq.cwiseMax(low_).cwiseMin(high_);
  result.omega_sq = within;
  result.u = u_from_omega_sq_ * within;
  result.thrust = saturation_of(demand[0], result.u[0], max_thrust_n());
  for (int axis = 0; axis < 3; ++axis) {
    result.torque[static_cast<std::size_t>(axis)] =
        saturation_of(demand[axis + 1], result.u[axis + 1], 1.0);
  }
  return result;
}

MixerResult Mixer::idle() const {
  if (vehicle_.rotors.empty()) return {};
  if (allocation_) return allocation_->idle();
  MixerResult result;
  result.u = idle_eq3();
  result.omega_sq = mix_eq3(result.u, true).omega_sq;
  return result;
}

Vector4d Mixer::idle_eq3() const { return u_from_omega_sq_ * Vector4d::Constant(low_); }

std::array<double, base::kMaxOutputs> Mixer::outputs(const MixerResult& result) const {
  std::array<double, base::kMaxOutputs> out{};
  for (std::size_t i = 0; i < vehicle_.rotors.size(); ++i) {
    const base::Rotor& rotor = vehicle_.rotors[i];
    const auto index = static_cast<Eigen::Index>(i);
    const double omega_sq = index < result.omega_sq.size() ? result.omega_sq[index] : 0.0;
    const double omega = std::sqrt(std::max(omega_sq, 0.0));
    out[static_cast<std::size_t>(rotor.output)] = std::clamp(rotor.output_at(omega), 0.0, 1.0);
    if (!rotor.tilt || index >= result.tilt_rad.size()) continue;
    out[static_cast<std::size_t>(rotor.tilt->output)] =
        rotor.tilt->output_at(result.tilt_rad[index]);
  }
  return out;
}

double Mixer::max_thrust_n() const {
  if (allocation_) return allocation_->max_thrust_n();
  return (u_from_omega_sq_ * Vector4d::Constant(high_))[0];
}

bool Mixer::set_lost(RotorSet lost) {
  if (lost == lost_) return true;
  if (!allocation_) return false;
  const ControlAllocation without(AllocationSetup::of(vehicle_, lost), lost);
  if (!without.carries(hover_n_)) return false;
  allocation_ = without;
  lost_ = lost;
  side_force_n_ = without.side_force_n(hover_n_);
  heading_torque_nm_ = heading_torque_of(without, hover_n_);
  return true;
}

}  // namespace cas::fcu
