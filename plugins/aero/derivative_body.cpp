// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/derivative_body.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"
#include "plugins/aero/stall_blend.hpp"

namespace cas::sim {
namespace {

/// Drag coefficient of a flat plate across the air, by its aspect ratio: the fit of Gazebo's
/// advanced lift and drag to Hoerner's measurements.
double plate_drag_of(double aspect_ratio) {
  return 2.0 / (1.0 + std::exp(-0.224 - 0.115 * std::max(aspect_ratio, 1.0 / aspect_ratio)));
}

}  // namespace

DerivativeBody::DerivativeBody(const base::DerivativeParams& params)
    : form_(params.form),
      area_m2_(params.area_m2),
      span_m_(params.span_m),
      chord_m_(params.chord_m),
      induced_factor_(1.0 / (M_PI * params.efficiency * params.aspect_ratio())),
      plate_drag_(plate_drag_of(params.aspect_ratio())),
      stall_rad_(params.stall_rad),
      stall_sharpness_(params.stall_sharpness),
      centre_B_m_(params.centre_B_m),
      lift_(row_of(params.lift, span_m_, chord_m_)),
      drag_(row_of(params.drag, span_m_, chord_m_)),
      side_(row_of(params.side, span_m_, chord_m_)),
      roll_(row_of(params.roll, span_m_, chord_m_)),
      pitch_(row_of(params.pitch, span_m_, chord_m_)),
      yaw_(row_of(params.yaw, span_m_, chord_m_)) {}

DerivativeBody::Row DerivativeBody::row_of(const base::CoefficientRow& row, double span_m,
                                           double chord_m) {
  Row result{.zero = row.zero,
             .alpha = row.alpha,
             .beta = row.beta,
             .p = 0.5 * span_m * row.p,
             .q = 0.5 * chord_m * row.q,
             .r = 0.5 * span_m * row.r,
             .surfaces = {}};
  std::ranges::copy(row.surfaces, result.surfaces.begin());
  return result;
}

Wrench DerivativeBody::wrench(const Eigen::Vector3d& v_B, const Eigen::Vector3d& w_B,
                              double air_density_kg_m3, std::span<const double> angles) const {
  const Eigen::Vector3d v_D = base::swap_BD(v_B);
  const Eigen::Vector3d w_D = base::swap_BD(w_B);
  const double u = v_D.x();
  const double w = v_D.z();
  const double speed = v_D.norm();
  const double in_plane = std::hypot(u, w);  // speed in the plane of symmetry
  const double cos_a = in_plane > 0 ? u / in_plane : 1.0;
  const double sin_a = in_plane > 0 ? w / in_plane : 0.0;
  const double alpha = std::atan2(w, u);
  const double attached = attached_share(alpha, stall_rad_, stall_sharpness_);
  const double separated = 1.0 - attached;

  // The parts of a coefficient: by deflections, by angle of attack, and over the speed by sideslip
  // and rates.
  const double angle = attached * alpha + separated * sin_a;
  const double effect = attached + separated * cos_a;
  const auto by_surfaces = [&](const Row& row) {
    double sum = 0;
    for (std::size_t i = 0; i < angles.size(); ++i) sum += row.surfaces[i] * angles[i];
    return effect * sum;
  };
  const auto by_angles = [&](const Row& row) {
    return row.zero + row.alpha * angle + by_surfaces(row);
  };
  const auto by_motion = [&](const Row& row) {
    return row.beta * v_D.y() + row.p * w_D.x() + row.q * w_D.y() + row.r * w_D.z();
  };

  // Lift and drag, coefficients times the speed in the plane. Of the lift's square in form avl that
  // of the part by motion is left out, which has no direction at rest.
  const double linear = lift_.zero + lift_.alpha * alpha;
  const double still =
      attached * linear + separated * 2 * sin_a * std::abs(sin_a) * cos_a + by_surfaces(lift_);
  const double moving = by_motion(lift_);
  const double lift = in_plane * still + moving;
  double drag = separated * plate_drag_ * sin_a * sin_a * in_plane + by_motion(drag_);
  if (form_ == base::DerivativeForm::kBeard) {
    drag += in_plane * (by_angles(drag_) + attached * induced_factor_ * linear * linear);
  } else {
    drag += in_plane * (attached * drag_.zero + drag_.alpha * angle + by_surfaces(drag_)) +
            attached * induced_factor_ * still * (in_plane * still + 2 * moving);
  }

  // Side force and moments.
  const auto across = [&](const Row& row) {
    return in_plane * in_plane * by_angles(row) + speed * by_motion(row);
  };
  const double scale = 0.5 * air_density_kg_m3 * area_m2_;
  const Eigen::Vector3d force_D(lift * w - drag * u, across(side_), -lift * u - drag * w);
  const Eigen::Vector3d torque_D(span_m_ * across(roll_), chord_m_ * across(pitch_),
                                 span_m_ * across(yaw_));
  Wrench result{scale * base::swap_BD(force_D), scale * base::swap_BD(torque_D)};
  result.torque_B += centre_B_m_.cross(result.force_B);
  return result;
}

}  // namespace cas::sim
