// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/loop_design.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/gravity.hpp"

namespace cas::fcu {
namespace {

using Complex = std::complex<double>;

/// The low-pass of RateController; 0 Hz switches it off.
Complex low_pass(Complex s, double cutoff_hz) {
  if (cutoff_hz <= 0) return 1;
  const Complex x = s / (2 * M_PI * cutoff_hz);
  return 1.0 / (1.0 + std::sqrt(2.0) * x + x * x);
}

// Frequencies that are looked at: finer than a hundredth of a decade.
constexpr double kLowest_rad_s = 0.01;
constexpr double kHighest_rad_s = 1e4;
constexpr double kStep = 1.005;

/// Angle from `before` to `now`, which are neighbours: within half a turn.
double turned(Complex before, Complex now) { return std::arg(now / before); }

/// Full torque about Dx, Dy and Dz, N m.
Eigen::Vector3d full_torque_nm(const base::Vehicle& vehicle) {
  return {vehicle.scales.u2_max_nm, vehicle.scales.u3_max_nm, vehicle.scales.u4_max_nm};
}

/// The loop about an axis without its gains.
RateLoop plant(const base::Vehicle& vehicle, int axis, const ControlParams& params,
               double delay_s) {
  return {.lag_s = motor_lag_s(vehicle),
          .lead_s = axis == 2 ? yaw_lead_s(vehicle) : 0,
          .delay_s = delay_s,
          .gyro_cutoff_hz = params.gyro_cutoff_hz,
          .dgyro_cutoff_hz = params.dgyro_cutoff_hz};
}

}  // namespace

Complex RateLoop::at(double w_rad_s) const {
  const Complex s(0, w_rad_s);
  const Complex gyro = low_pass(s, gyro_cutoff_hz);
  const Complex pid =
      (1.0 + i_per_p / s) * gyro + d_per_p * s * gyro * low_pass(s, dgyro_cutoff_hz);
  const Complex motors = (lead_s * s + 1.0) / (lag_s * s + 1.0);
  return gain_rad_s * pid / s * motors * std::exp(-delay_s * s);
}

LoopMargins margins(const RateLoop& loop) {
  LoopMargins margins{.gain = INFINITY};
  Complex before = loop.at(kLowest_rad_s);
  double phase = std::arg(before);
  if (phase > 0) phase -= 2 * M_PI;  // two integrators: a little above -180 degrees, not below +180
  for (double w = kLowest_rad_s * kStep; w < kHighest_rad_s; w *= kStep) {
    const Complex now = loop.at(w);
    const double next = phase + turned(before, now);
    if (std::abs(before) >= 1 && std::abs(now) < 1) {
      margins.crossover_rad_s = w;
      margins.phase_rad = M_PI + next;
    }
    if (phase > -M_PI && next <= -M_PI && !std::isfinite(margins.gain)) {
      margins.gain = 1 / std::abs(now);
    }
    before = now;
    phase = next;
  }
  return margins;
}

double derived_gain_rad_s(const RateLoop& usual) {
  const auto keeps_margin = [&usual](double share) {
    RateLoop slower = usual;
    slower.gain_rad_s *= share;
    slower.i_per_p *= share;
    const LoopMargins left = margins(slower);
    return left.phase_rad >= kPhaseMargin_rad && left.gain >= kGainMargin;
  };
  if (keeps_margin(1)) return usual.gain_rad_s;
  double low = 0;
  double high = 1;
  constexpr int kHalvings = 20;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (keeps_margin(middle) ? low : high) = middle;
  }
  return low * usual.gain_rad_s;
}

double motor_lag_s(const base::Vehicle& vehicle) {
  double lag_s = 0;
  for (const base::Rotor& rotor : vehicle.rotors) {
    const base::RotorParams& params = rotor.params;
    lag_s = std::max(lag_s, (params.time_constant_up_s + params.time_constant_down_s) / 2 +
                                params.esc_dead_time_s);
  }
  return lag_s;
}

double yaw_lead_s(const base::Vehicle& vehicle) {
  const double weight_n = vehicle.mass_kg * base::kStandardGravity_m_s2;
  const double hover = std::sqrt(std::min(1.0, weight_n / vehicle.scales.u1_max_n));
  const base::Effectiveness wrench_B = vehicle.effectiveness();
  double inertia = 0;
  double moment = 0;
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    const base::Rotor& rotor = vehicle.rotors[i];
    if (rotor.tilt) return 0;  // the servo yaws
    const double c = wrench_B(5, static_cast<Eigen::Index>(i));
    const double reaction = -rotor.spin * rotor.axis_B.z() * rotor.params.inertia_kg_m2;
    inertia += c < 0 ? -reaction : reaction;
    moment += 2 * std::abs(c) * hover * rotor.params.omega_max_rad_s;
  }
  return inertia > 0 && moment > 0 ? inertia / moment : 0;
}

std::array<RateLoop, 3> rate_loops(const base::Vehicle& vehicle, const ControlParams& params,
                                   double delay_s) {
  const PidGains* const gains[] = {&params.rate_roll, &params.rate_pitch, &params.rate_yaw};
  const Eigen::Vector3d torque_nm = full_torque_nm(vehicle);
  std::array<RateLoop, 3> loops;
  for (int axis = 0; axis < 3; ++axis) {
    const PidGains& own = *gains[axis];
    RateLoop& loop = loops[static_cast<std::size_t>(axis)];
    loop = plant(vehicle, axis, params, delay_s);
    if (torque_nm[axis] <= 0 || own.p <= 0) continue;
    loop.gain_rad_s = own.p * torque_nm[axis] / vehicle.inertia_kg_m2[axis];
    loop.i_per_p = own.i / own.p;
    loop.d_per_p = own.d / own.p;
  }
  return loops;
}

double derive_gains(const base::Vehicle& vehicle, double delay_s, ControlParams& params) {
  constexpr double kTiltGain_rad_s = 20;
  constexpr double kYawGain_rad_s = 7;
  const auto derive = [&](PidGains& gains, int axis, double most_rad_s, double i_per_p,
                          double d_per_p) {
    RateLoop usual = plant(vehicle, axis, params, delay_s);
    usual.gain_rad_s = most_rad_s;
    usual.i_per_p = i_per_p;
    usual.d_per_p = d_per_p;
    const double gain = derived_gain_rad_s(usual);
    const double share = gain / most_rad_s;
    gains.p = gain * vehicle.inertia_kg_m2[axis] / full_torque_nm(vehicle)[axis];
    gains.i = share * i_per_p * gains.p;
    gains.d = d_per_p * gains.p;
    return share;
  };
  const double tilt = derive(params.rate_roll, 0, kTiltGain_rad_s, 1.5, 0.012);
  derive(params.rate_pitch, 1, kTiltGain_rad_s, 1.5, 0.012);
  const double yaw = derive(params.rate_yaw, 2, kYawGain_rad_s, 0.8, 0);
  params.roll_p *= tilt;
  params.pitch_p *= tilt;
  params.yaw_p *= yaw;
  params.xy_velocity.p *= tilt;
  params.xy_velocity.i *= tilt;
  params.xy_p *= tilt;
  params.hover_thrust = vehicle.mass_kg * base::kStandardGravity_m_s2 / vehicle.scales.u1_max_n;
  params.detect_rotor_loss = true;
  params.side_share = 0.7;
  return tilt;
}

}  // namespace cas::fcu
