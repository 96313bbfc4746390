// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/motor/rotor_inflow.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {
namespace {

/// A value and its derivative by v.
struct Slope {
  double value = 0;
  double rate = 0;
};

/// Glauert's v sqrt(x^2 + (z + v)^2).
Slope glauert(double v, double z, double x) {
  const double through = z + v;
  const double speed = std::sqrt(x * x + through * through);
  return {v * speed, speed > 0 ? speed + v * through / speed : 0.0};
}

/// Share of the fit for vortex rings, by the left side of its border over t.
Slope fit_share(const Slope& border) {
  constexpr double kBlend = 0.2;
  if (border.value <= 1) return {1, 0};
  if (border.value >= 1 + kBlend) return {0, 0};
  const double u = (1 + kBlend - border.value) / kBlend;
  return {u * u * (3 - 2 * u), -6 * u * (1 - u) / kBlend * border.rate};
}

/// momentum_thrust() for v from 0.
Slope thrust_of(double v, double z, double x) {
  const Slope ideal = glauert(v, z, x);
  const double sink = -z;
  const double left = 1.991 * sink - v;
  if (z >= 0 || left <= 0) return ideal;

  // The fit, solved for t, and where it holds.
  const double t = sink * (0.373 * sink * sink + 0.598 * x * x) / left;
  const Slope fit{t, t / left};
  const double root = std::sqrt(t);
  const double squares = 4 * sink * sink + 1.5 * x * x;
  const Slope border{squares / t - 12 * sink / root + 9,
                     (6 * sink / root - squares / t) / t * fit.rate};
  const Slope share = fit_share(border);
  const double more = fit.value - ideal.value;
  return {ideal.value + share.value * more,
          ideal.rate + share.value * (fit.rate - ideal.rate) + share.rate * more};
}

/// The same for any v.
Slope odd_thrust_of(double v, const RotorAir& air) {
  if (v >= 0) return thrust_of(v, air.climb, air.edgewise);
  const Slope mirrored = thrust_of(-v, -air.climb, air.edgewise);
  return {-mirrored.value, mirrored.rate};
}

/// v that satisfies t(v) + slope v = sum. The left side rises with v and is 0 at 0.
/// @param low, high  v between which the solution lies
double solve(double slope, double sum, const RotorAir& air, double low, double high) {
  // First guess: a climb, then one step with the edgewise flow.
  const double half = 0.5 * (air.climb + slope);
  double v = std::clamp(-half + std::sqrt(std::max(0.0, half * half + sum)), low, high);
  const double through = air.climb + v;
  v = std::clamp(sum / (slope + std::sqrt(air.edgewise * air.edgewise + through * through)), low,
                 high);
  constexpr int kMostSteps = 60;     // those of bisection alone
  constexpr double kSquared = 1e-7;  // Newton's next error is some square of its step
  for (int i = 0; i < kMostSteps; ++i) {
    const Slope thrust = odd_thrust_of(v, air);
    const double rest = thrust.value + slope * v - sum;
    (rest > 0 ? high : low) = v;
    const double rate = thrust.rate + slope;
    const double newton = rate > 0 ? v - rest / rate : low;
    if (newton < low || newton > high) {
      v = 0.5 * (low + high);
      continue;
    }
    const double step = std::abs(newton - v);
    v = newton;
    if (step <= kSquared * (1 + std::abs(v))) break;
  }
  return v;
}

}  // namespace

double momentum_thrust(double induced, const RotorAir& air) {
  return odd_thrust_of(induced, air).value;
}

double induced_velocity(const RotorAir& air) {
  // From climbs to vortex rings v is at most 2; the fastest sink has the least.
  return solve(0, 1, air, 0, 2);
}

RotorInflow rotor_inflow(double slope, double advance_ratio, const RotorAir& air) {
  const double pitch = (1 + slope) * (1 + 1.5 * advance_ratio * advance_ratio);
  const double sum = pitch - slope * air.climb;
  const double most = sum / slope;  // if the air took no thrust to move
  const double induced = solve(slope, sum, air, std::min(0.0, most), std::max(0.0, most));
  return {.thrust = pitch - slope * (air.climb + induced), .induced = induced};
}

RotorLoad rotor_load(const RotorFlight& flight) {
  constexpr double kInducedPowerFactor = 1.15;  // Leishman, Ch. 2: from measurements
  constexpr double kProfilePowerRise = 4.65;    // over mu^2, the same book, Ch. 5
  const double area = M_PI * flight.radius_m * flight.radius_m;
  const double tip_speed = flight.omega_rad_s * flight.radius_m;
  const double v_hover = std::sqrt(flight.hover_thrust_n / (2 * flight.density_kg_m3 * area));

  // Not faster than the tips.
  const double ratio =
      (flight.climb_m_s * flight.climb_m_s + flight.edgewise_m_s * flight.edgewise_m_s) /
      (tip_speed * tip_speed);
  const double held = 1 / std::sqrt(std::sqrt(1 + ratio * ratio));
  const double climb = held * flight.climb_m_s;
  const double edgewise = held * flight.edgewise_m_s;

  const double mu = edgewise / tip_speed;
  const RotorAir air{.climb = climb / v_hover, .edgewise = edgewise / v_hover};
  const RotorInflow inflow = rotor_inflow(flight.slope, mu, air);

  const double hover_power = flight.hover_torque_n_m * flight.omega_rad_s;
  const double ideal_power = flight.hover_thrust_n * v_hover;
  const double factor = std::min(kInducedPowerFactor, hover_power / ideal_power);
  const double power = ideal_power * inflow.thrust * (factor * inflow.induced + air.climb) +
                       (hover_power - factor * ideal_power) * (1 + kProfilePowerRise * mu * mu);
  return {.thrust = inflow.thrust, .torque = hover_power > 0 ? power / hover_power : 1.0};
}

}  // namespace cas::sim
