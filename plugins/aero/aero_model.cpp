// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/aero_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "plugins/aero/propeller_wash.hpp"

namespace cas::sim {
namespace {

/// Angular velocity with respect to air that changes over the vehicle: the rates that give each
/// wing tip, nose and tail the same air across them. MIL-F-8785C has its gusts p, q and r so.
Eigen::Vector3d rates_in_air_B(const Eigen::Vector3d& w_B, const Eigen::Matrix3d& gradient_B) {
  return w_B - Eigen::Vector3d(gradient_B(2, 1), -gradient_B(2, 0), gradient_B(1, 0));
}

/// Velocity of the air far behind a wing of elliptic lift: 2 C_L / (pi AR) of the airspeed, against
/// the lift. As momentum: 4 L / (rho pi b^2 V), with the part of the force in the plane of symmetry
/// across the air for L.
Eigen::Vector3d far_downwash_B(Eigen::Vector3d force_B, const Eigen::Vector3d& v_B,
                               double density_kg_m3, double span_m) {
  const double speed = v_B.norm();
  if (!(speed > 0) || !(density_kg_m3 > 0)) return Eigen::Vector3d::Zero();
  force_B.y() = 0;
  const Eigen::Vector3d along_B = v_B / speed;
  const Eigen::Vector3d lift_B = force_B - force_B.dot(along_B) * along_B;
  return -4 / (density_kg_m3 * std::numbers::pi * span_m * span_m * speed) * lift_B;
}

}  // namespace

AeroModel::AeroModel(const base::AeroParams& params, std::span<const base::Rotor> rotors)
    : servos_(params.surfaces),
      wing_span_m_(params.wing_span_m),
      rotors_(rotors.begin(), rotors.end()),
      omega_rad_s_(base::RotorVector::Zero(static_cast<Eigen::Index>(rotors.size()))) {
  if (params.derivatives) body_.emplace(*params.derivatives);
  for (const base::PanelParams& panel : params.panels) panels_.emplace_back(panel);
  const auto downwash =
      std::stable_partition(panels_.begin(), panels_.end(),
                            [](const LiftingPanel& panel) { return panel.downwash_share() == 0; });
  in_clean_air_ = static_cast<std::size_t>(downwash - panels_.begin());
  has_wash_ = !rotors_.empty() && std::ranges::any_of(panels_, [](const LiftingPanel& panel) {
    return panel.in_wash_of() >= 0;
  });
}

Eigen::Vector3d AeroModel::velocity_B(const LiftingPanel& panel, const Flow& flow) const {
  const Eigen::Vector3d v_B = flow.v_B + flow.turn_B * panel.position_B_m();
  if (!has_wash_ || panel.in_wash_of() < 0) return v_B;
  const auto index = static_cast<std::size_t>(panel.in_wash_of());
  const base::Rotor& rotor = rotors_[index];
  const Eigen::Vector3d hub_v_B = flow.v_B + flow.turn_B * rotor.position_B_m;
  const double axial = rotor.axis_B.dot(hub_v_B);
  const double thrust = wash_thrust_n(rotor, omega_rad_s_[static_cast<Eigen::Index>(index)], axial,
                                      flow.density_kg_m3);
  const double behind = rotor.axis_B.dot(rotor.position_B_m - panel.position_B_m());
  return v_B +
         rotor.axis_B * wash_m_s(thrust, axial, flow.density_kg_m3, rotor.params.radius_m, behind);
}

void AeroModel::add(const LiftingPanel& panel, const Eigen::Vector3d& v_B, const Flow& flow,
                    std::span<const double> x, Wrench& wrench) {
  const double deflection =
      panel.surface() >= 0 ? x[static_cast<std::size_t>(panel.surface())] : 0.0;
  panel.add(v_B, flow.density_kg_m3, deflection, wrench.force_B, wrench.torque_B);
}

void AeroModel::evaluate(const BodyState& body, const Environment& environment,
                         std::span<const double> x, std::span<double> x_dot, Wrench& wrench) const {
  servos_.rates(x, x_dot);

  const Eigen::Matrix3d R_BW = body.q_WB.conjugate().toRotationMatrix();
  const Eigen::Vector3d v_air_B = R_BW * (body.v_WB - environment.wind_W);
  const Eigen::Vector3d& w_B = body.w_WB_B;
  Eigen::Matrix3d turn_B;  // velocity through the air, less v_air_B, by place
  turn_B << 0, -w_B.z(), w_B.y(), w_B.z(), 0, -w_B.x(), -w_B.y(), w_B.x(), 0;
  Eigen::Vector3d w_air_B = w_B;
  if (environment.wind_gradient_W) {
    const Eigen::Matrix3d gradient_B = R_BW * *environment.wind_gradient_W * R_BW.transpose();
    turn_B -= gradient_B;
    w_air_B = rates_in_air_B(w_B, gradient_B);
  }

  const Flow flow{v_air_B, turn_B, environment.air_density_kg_m3};
  const bool has_downwash = in_clean_air_ < panels_.size();
  Wrench sends_down;
  Wrench& wing = has_downwash ? sends_down : wrench;
  if (body_) {
    const Wrench own =
        body_->wrench(v_air_B + turn_B * body_->centre_B_m(), w_air_B, flow.density_kg_m3, x);
    wing.force_B += own.force_B;
    wing.torque_B += own.torque_B;
  }
  const std::span<const LiftingPanel> panels = panels_;
  for (const LiftingPanel& panel : panels.first(in_clean_air_)) {
    add(panel, velocity_B(panel, flow), flow, x, wing);
  }
  if (!has_downwash) return;
  const Eigen::Vector3d downwash_B =
      far_downwash_B(wing.force_B, flow.v_B, flow.density_kg_m3, wing_span_m_);
  for (const LiftingPanel& panel : panels.subspan(in_clean_air_)) {
    add(panel, velocity_B(panel, flow) - panel.downwash_share() * downwash_B, flow, x, wrench);
  }
  wrench.force_B += wing.force_B;
  wrench.torque_B += wing.torque_B;
}

}  // namespace cas::sim
