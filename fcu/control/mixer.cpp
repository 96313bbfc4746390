// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/mixer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace cas::fcu {

using Eigen::Vector4d;

namespace {

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

Saturation saturation(double wanted, double achieved, double scale) {
  const double tolerance = 1e-6 * scale;
  return {achieved<wanted - tolerance, achieved> wanted + tolerance};
}

}  // namespace

Mixer::Mixer(const base::Vehicle& vehicle)
    : u_from_omega_sq_(vehicle.mixing_matrix()),
      omega_sq_from_u_(u_from_omega_sq_.inverse()),
      low_(std::pow(vehicle.rotor.omega_idle_rad_s, 2)),
      high_(std::pow(vehicle.rotor.omega_max_rad_s, 2)) {}

MixerResult Mixer::mix(const Vector4d& demand, bool may_lift) const {
  const Vector4d thrust_column = omega_sq_from_u_.col(0);

  // Roll and pitch, scaled only when no thrust makes room for them.
  Vector4d tilt = omega_sq_from_u_.col(1) * demand[1] + omega_sq_from_u_.col(2) * demand[2];
  ThrustRange range = thrust_range(thrust_column, tilt, low_, high_);
  if (!may_lift && range.from > demand[0]) {
    const Vector4d level = thrust_column * std::max(demand[0], idle()[0]);
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
  result.omega_sq = omega_sq.cwiseMax(low_).cwiseMin(high_);
  result.u = u_from_omega_sq_ * result.omega_sq;
  result.thrust = saturation(demand[0], result.u[0], max_thrust_n());
  for (int axis = 0; axis < 3; ++axis) {
    result.torque[static_cast<std::size_t>(axis)] =
        saturation(demand[axis + 1], result.u[axis + 1], 1.0);
  }
  return result;
}

Vector4d Mixer::motor_outputs(const Vector4d& omega_sq) const {
  const double idle = std::sqrt(low_);
  const double span = std::sqrt(high_) - idle;
  return ((omega_sq.cwiseMax(0.0).cwiseSqrt().array() - idle) / span).cwiseMax(0.0).cwiseMin(1.0);
}

Vector4d Mixer::idle() const { return u_from_omega_sq_ * Vector4d::Constant(low_); }

double Mixer::max_thrust_n() const { return (u_from_omega_sq_ * Vector4d::Constant(high_))[0]; }

}  // namespace cas::fcu
