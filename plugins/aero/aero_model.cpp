// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/aero_model.hpp"

#include <Eigen/Geometry>

namespace cas::sim {
namespace {

/// Angular velocity with respect to air that changes over the vehicle: the rates that give each
/// wing tip, nose and tail the same air across them. MIL-F-8785C has its gusts p, q and r so.
Eigen::Vector3d rates_in_air_B(const Eigen::Vector3d& w_B, const Eigen::Matrix3d& gradient_B) {
  return w_B - Eigen::Vector3d(gradient_B(2, 1), -gradient_B(2, 0), gradient_B(1, 0));
}

}  // namespace

AeroModel::AeroModel(const base::AeroParams& params) : servos_(params.surfaces) {
  if (params.derivatives) body_.emplace(*params.derivatives);
  for (const base::PanelParams& panel : params.panels) panels_.emplace_back(panel);
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

  const double density = environment.air_density_kg_m3;
  if (body_) {
    const Wrench own = body_->wrench(v_air_B + turn_B * body_->centre_B_m(), w_air_B, density, x);
    wrench.force_B += own.force_B;
    wrench.torque_B += own.torque_B;
  }
  for (const LiftingPanel& panel : panels_) {
    const double deflection =
        panel.surface() >= 0 ? x[static_cast<std::size_t>(panel.surface())] : 0.0;
    panel.add(v_air_B + turn_B * panel.position_B_m(), density, deflection, wrench.force_B,
              wrench.torque_B);
  }
}

}  // namespace cas::sim
