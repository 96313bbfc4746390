// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/wing_airframe.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"

namespace cas::fcu {

using Eigen::Vector3d;

namespace {

constexpr double kAlong = 0.5;  // of a rotor's axis: within 60 degrees

bool pushes(const base::Rotor& rotor) { return rotor.axis_B.x() > kAlong; }
bool lifts(const base::Rotor& rotor) { return rotor.axis_B.z() > kAlong && !pushes(rotor); }

/// Deflection at output 1; the mean of both sides.
double full_rad(const base::ControlSurface& surface) {
  return (surface.max_rad - surface.min_rad) / 2;
}

void add_panel(const base::PanelParams& panel, const base::AeroParams& aero, WingFigures& out) {
  const double lift_m2 = panel.area_m2 * panel.lift_slope_per_rad;
  const Vector3d& normal_B = panel.normal_B;
  const Vector3d arm_D = base::swap_BD(panel.position_B_m.cross(normal_B));  // of a lift of 1
  const double up = normal_B.z();
  out.zero_lift_rad += lift_m2 * up * up * panel.zero_lift_rad;
  out.lift_slope_m2 += lift_m2 * up * up;
  out.stiffness_m3 -= lift_m2 * up * arm_D.y();
  out.moment_zero_m3 -= lift_m2 * panel.zero_lift_rad * arm_D.y();
  out.damping_m4 += lift_m2 * arm_D.cwiseAbs2();
  if (panel.surface < 0) return;
  const base::ControlSurface& surface = aero.surfaces[static_cast<std::size_t>(panel.surface)];
  const double at_full = panel.area_m2 * panel.surface_lift_per_rad * full_rad(surface);
  out.surface_moment_m3.col(panel.surface) += at_full * arm_D;
  out.surface_lift_m2[panel.surface] += at_full * up;
}

void add_derivatives(const base::DerivativeParams& body, const base::AeroParams& aero,
                     WingFigures& out) {
  const double s = body.area_m2;
  const double b = body.span_m;
  const double c = body.chord_m;
  out.lift_slope_m2 += s * body.lift.alpha;
  out.zero_lift_rad -= s * body.lift.zero;
  out.stiffness_m3 -= s * c * body.pitch.alpha;
  out.moment_zero_m3 += s * c * body.pitch.zero;
  out.damping_m4 -= s / 2 * Vector3d(b * b * body.roll.p, c * c * body.pitch.q, b * b * body.yaw.r);
  for (std::size_t i = 0; i < aero.surfaces.size(); ++i) {
    const auto at = [i](const base::CoefficientRow& row) {
      return i < row.surfaces.size() ? row.surfaces[i] : 0.0;
    };
    const auto column = static_cast<Eigen::Index>(i);
    const double full = s * full_rad(aero.surfaces[i]);
    out.surface_moment_m3.col(column) +=
        full * Vector3d(b * at(body.roll), c * at(body.pitch), b * at(body.yaw));
    out.surface_lift_m2[column] += full * at(body.lift);
  }
}

}  // namespace

std::vector<std::size_t> pushing_rotors(const base::Vehicle& vehicle) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    if (pushes(vehicle.rotors[i])) found.push_back(i);
  }
  return found;
}

AirframeKind airframe_kind(const base::Vehicle& vehicle) {
  if (!vehicle.aero || !std::ranges::any_of(vehicle.rotors, pushes)) {
    return AirframeKind::kMulticopter;
  }
  return std::ranges::any_of(vehicle.rotors, lifts) ? AirframeKind::kVtol : AirframeKind::kPlane;
}

base::Vehicle lifting_part(const base::Vehicle& vehicle) {
  base::Vehicle part = vehicle;
  if (airframe_kind(vehicle) == AirframeKind::kMulticopter) return part;
  std::vector<int> index(vehicle.rotors.size(), -1);
  part.rotors.clear();
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    if (!lifts(vehicle.rotors[i])) continue;
    index[i] = part.rotor_count();
    part.rotors.push_back(vehicle.rotors[i]);
  }
  for (base::Rotor& rotor : part.rotors) {
    if (rotor.wake) rotor.wake->upper = index[static_cast<std::size_t>(rotor.wake->upper)];
  }
  if (!part.rotors.empty()) part.scales = part.control_scales();
  return part;
}

WingFigures WingFigures::of(const base::AeroParams& aero) {
  WingFigures figures;
  const auto count = static_cast<Eigen::Index>(aero.surfaces.size());
  figures.surface_moment_m3.setZero(3, count);
  figures.surface_lift_m2.setZero(count);
  for (const base::PanelParams& panel : aero.panels) add_panel(panel, aero, figures);
  if (aero.derivatives) add_derivatives(*aero.derivatives, aero, figures);
  if (figures.lift_slope_m2 > 0) figures.zero_lift_rad /= figures.lift_slope_m2;
  figures.surface_lift_m2 = figures.surface_lift_m2.cwiseAbs().eval();
  return figures;
}

Vector3d WingFigures::full_moment_m3() const {
  constexpr double kStrong = 0.5;
  Vector3d full = Vector3d::Zero();
  if (surface_moment_m3.cols() == 0) return full;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::RowVectorXd size = surface_moment_m3.row(axis).cwiseAbs();
    full[axis] = (size.array() >= kStrong * size.maxCoeff()).select(size, 0.0).sum();
  }
  return full;
}

double trim_demand(const WingFigures& figures, double alpha_rad) {
  const double full_m3 = figures.full_moment_m3().y();
  if (full_m3 <= 0) return 0;
  return (figures.stiffness_m3 * alpha_rad - figures.moment_zero_m3) / full_m3;
}

double forward_thrust_n(const base::Vehicle& vehicle, double airspeed_m_s) {
  constexpr double kLeftOfPropeller = 0.5;
  double thrust_n = 0;
  for (const std::size_t i : pushing_rotors(vehicle)) {
    const base::Rotor& rotor = vehicle.rotors[i];
    const double full_n =
        rotor.params.thrust_coefficient * std::pow(rotor.params.omega_max_rad_s, 2);
    const double faded = rotor.params.zero_thrust_speed_m_s > 0
                             ? 1 - airspeed_m_s / rotor.params.zero_thrust_speed_m_s
                             : 1.0;
    const double by_propeller = airspeed_m_s > 0 ? kLeftOfPropeller : 1.0;
    thrust_n += full_n * (rotor.propeller ? by_propeller : std::max(faded, 0.1));
  }
  return thrust_n;
}

namespace {

/// Rate loop about one axis.
/// @param full_rad_s2     acceleration of full deflection at cruise
/// @param damping_per_s   of the rate
/// @param steady_rad_s    rate that full deflection gives in the end
/// @param wanted_rad_s    gain of the loop
void derive_rate(double full_rad_s2, double steady_rad_s, double wanted_rad_s, double i_per_s,
                 PidGains& gains, double& feed_forward) {
  if (full_rad_s2 <= 0 || steady_rad_s <= 0) return;
  feed_forward = 1 / steady_rad_s;
  gains.p = wanted_rad_s / full_rad_s2;
  gains.i = i_per_s * (feed_forward + gains.p);
}

void derive_rates(const base::Vehicle& vehicle, const WingFigures& wing, WingParams& params) {
  constexpr double kRateGain_rad_s = 8;
  constexpr double kYawDamping_per_s = 3;
  constexpr double kIntegrator_per_s = 1;
  const double v = params.airspeed_trim_m_s;
  const double pressure_pa = base::isa::density_kg_m3(0) / 2 * v * v;
  const Vector3d full = pressure_pa * wing.full_moment_m3().cwiseQuotient(vehicle.inertia_kg_m2);
  const Vector3d damping = pressure_pa / v * wing.damping_m4.cwiseQuotient(vehicle.inertia_kg_m2);
  Vector3d& forward = params.rate_feed_forward;
  derive_rate(full.x(), full.x() / std::max(damping.x(), 0.1), kRateGain_rad_s, kIntegrator_per_s,
              params.roll_rate, forward.x());
  // A steady pitch rate turns the path along with it: lift against the stiffness.
  const double heave_per_s = pressure_pa * wing.lift_slope_m2 / (vehicle.mass_kg * v);
  const double stiffness_per_s2 = pressure_pa * wing.stiffness_m3 / vehicle.inertia_kg_m2.y();
  const double held = std::max(stiffness_per_s2, 0.0) + damping.y() * heave_per_s;
  derive_rate(full.y(), full.y() * heave_per_s / std::max(held, 0.1), kRateGain_rad_s,
              kIntegrator_per_s, params.pitch_rate, forward.y());
  derive_rate(full.z(), full.z() / std::max(damping.z(), 0.1), kYawDamping_per_s, 0,
              params.yaw_rate, forward.z());
}

void derive_energy(const base::Vehicle& vehicle, WingParams& params) {
  constexpr double kGlideRatio = 7;
  constexpr double kRunway_m_s2 = 10;
  constexpr double kTransition_m_s2 = 8;
  const double weight_n = vehicle.mass_kg * base::kStandardGravity_m_s2;
  const double v = params.airspeed_trim_m_s;
  const double static_n = forward_thrust_n(vehicle, 0);
  const double there_n = forward_thrust_n(vehicle, v);
  const auto share = [](double wanted_n, double have_n) {
    return have_n > 0 ? std::clamp(wanted_n / have_n, 0.0, 1.0) : 1.0;
  };
  const double drag_n = weight_n / kGlideRatio;
  params.throttle_trim = share(drag_n, there_n);
  params.throttle_max = share(drag_n + weight_n * params.climb_max_m_s / v, there_n);
  params.sink_min_m_s = v / kGlideRatio;
  params.runway_throttle = share(vehicle.mass_kg * kRunway_m_s2, static_n);
  params.transition_throttle = share(vehicle.mass_kg * kTransition_m_s2, static_n);
}

}  // namespace

void derive_wing(const base::Vehicle& vehicle, WingParams& params) {
  if (!vehicle.aero) return;
  const double cruise = vehicle.aero->cruise_m_s;
  params.airspeed_trim_m_s = cruise;
  params.airspeed_min_m_s = cruise * 2 / 3;
  params.airspeed_max_m_s = cruise * 4 / 3;
  params.land_airspeed_m_s = cruise * 0.8;
  params.transition_airspeed_m_s = cruise * 0.8;
  params.blend_airspeed_m_s = cruise * 0.5;
  derive_rates(vehicle, WingFigures::of(*vehicle.aero), params);
  derive_energy(vehicle, params);
}

}  // namespace cas::fcu
