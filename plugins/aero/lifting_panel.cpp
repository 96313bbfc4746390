// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/lifting_panel.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "plugins/aero/stall_blend.hpp"

namespace cas::sim {
namespace {

/// Beyond the stall along straight lines; `angle_rad` in 0..pi/2.
PanelCoefficients along_lines(const base::PanelParams& panel, double angle_rad) {
  const double below = std::min(angle_rad, panel.stall_rad);
  const double beyond = angle_rad - below;
  return {.lift = std::max(0.0, panel.lift_slope_per_rad * below +
                                    panel.after_stall_lift_slope_per_rad * beyond),
          .drag = std::abs(panel.drag_slope_per_rad * below +
                           panel.after_stall_drag_slope_per_rad * beyond)};
}

}  // namespace

PanelCoefficients panel_coefficients(const base::PanelParams& panel, double angle_rad,
                                     double sin_angle, double cos_angle, double deflection_rad) {
  const double by_surface = panel.surface_lift_per_rad * deflection_rad * cos_angle;
  PanelCoefficients c;
  if (panel.blends) {
    const double attached = attached_share(angle_rad, panel.stall_rad, panel.stall_sharpness);
    const double plate = (1.0 - attached) * panel.plate_normal_force * sin_angle;
    const double lift = attached * panel.lift_slope_per_rad * angle_rad;
    c.lift = lift + plate * cos_angle + by_surface;
    c.drag = attached * (panel.drag_slope_per_rad * std::abs(angle_rad) +
                         panel.induced_drag_factor * (lift + by_surface) * (lift + by_surface)) +
             plate * sin_angle;
  } else {
    const double size = std::abs(angle_rad);
    c = along_lines(panel, std::min(size, M_PI - size));
    c.lift = std::copysign(c.lift, sin_angle * cos_angle) + by_surface;
    c.drag += panel.induced_drag_factor * c.lift * c.lift;
  }
  c.drag += panel.drag_zero;
  c.moment = panel.moment_zero + panel.moment_slope_per_rad * sin_angle +
             panel.surface_moment_per_rad * deflection_rad * cos_angle;
  return c;
}

LiftingPanel::LiftingPanel(const base::PanelParams& params)
    : params_(params),
      left_B_(params.normal_B.cross(params.forward_B)),
      cos_zero_lift_(std::cos(params.zero_lift_rad)),
      sin_zero_lift_(std::sin(params.zero_lift_rad)) {
  if (params.polar.empty()) return;
  polar_ = PanelPolar(params.polar, params.plate_normal_force);
  cos_zero_lift_ = 1;  // the table counts from the chord
  sin_zero_lift_ = 0;
}

PanelCoefficients LiftingPanel::by_table(double angle_rad, double cos_angle, double deflection_rad,
                                         double reynolds) const {
  PanelCoefficients c = polar_.at(angle_rad, reynolds);
  c.lift += params_.surface_lift_per_rad * deflection_rad * cos_angle;
  c.moment += params_.surface_moment_per_rad * deflection_rad * cos_angle;
  c.drag += params_.induced_drag_factor * c.lift * c.lift;
  return c;
}

void LiftingPanel::add(const Eigen::Vector3d& v_B, double air_density_kg_m3, double deflection_rad,
                       Eigen::Vector3d& force_B, Eigen::Vector3d& torque_B) const {
  // The flow in the plane of chord and normal; turned so that its angle is 0 where lift is.
  const double u = params_.forward_B.dot(v_B);
  const double w = -params_.normal_B.dot(v_B);
  const double speed = std::sqrt(u * u + w * w);
  if (speed <= 0) return;
  const double cos_a = (u * cos_zero_lift_ + w * sin_zero_lift_) / speed;
  const double sin_a = (w * cos_zero_lift_ - u * sin_zero_lift_) / speed;
  const double angle = std::atan2(sin_a, cos_a);
  constexpr double kAirViscosity_Pa_s = 1.789e-5;  // at sea level, [ISO 2533]
  const PanelCoefficients c =
      polar_.empty() ? panel_coefficients(params_, angle, sin_a, cos_a, deflection_rad)
                     : by_table(angle, cos_a, deflection_rad,
                                air_density_kg_m3 * speed * params_.chord_m / kAirViscosity_Pa_s);

  const double scale = 0.5 * air_density_kg_m3 * params_.area_m2 * speed;
  const Eigen::Vector3d own_B = scale * ((c.lift * w - c.drag * u) * params_.forward_B +
                                         (c.lift * u + c.drag * w) * params_.normal_B);
  force_B += own_B;
  torque_B += params_.position_B_m.cross(own_B);
  if (params_.chord_m > 0) torque_B -= scale * speed * params_.chord_m * c.moment * left_B_;
}

}  // namespace cas::sim
