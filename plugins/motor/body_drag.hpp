// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include "base/config/vehicle.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

/// Drag of the fuselage: -c v at the centre of gravity, with v its velocity through the air, and
/// base::BodyDragParams at the centre of pressure, with its moment. The rotors' own drag is
/// RotorModel's. Lift, and the wash of the rotors on the fuselage, are not modelled.
class BodyDrag final : public ForceModel {
 public:
  /// @param coefficient  c, N per m/s
  explicit BodyDrag(double coefficient,
                    const std::optional<base::BodyDragParams>& quadratic = std::nullopt)
      : coefficient_(coefficient), quadratic_(quadratic) {}

  int state_count() const override { return 0; }
  void initial_states(std::span<double>) const override {}
  void evaluate(const BodyState& body, const Environment& environment, std::span<const double>,
                std::span<double>, Wrench& wrench) const override {
    const Eigen::Vector3d v_air_W = body.v_WB - environment.wind_W;
    const Eigen::Vector3d v_air_B = body.q_WB.conjugate() * v_air_W;
    wrench.force_B -= coefficient_ * v_air_B;
    if (!quadratic_) return;

    const Eigen::Vector3d& r_B = quadratic_->centre_B_m;
    Eigen::Vector3d v_B = v_air_B + body.w_WB_B.cross(r_B);
    if (environment.wind_gradient_W) {
      v_B -= body.q_WB.conjugate() * (*environment.wind_gradient_W * (body.q_WB * r_B));
    }
    const Eigen::Vector3d force_B =
        -0.5 * environment.air_density_kg_m3 * v_B.norm() * quadratic_->area_m2.cwiseProduct(v_B);
    wrench.force_B += force_B;
    wrench.torque_B += r_B.cross(force_B);
  }

 private:
  double coefficient_;
  std::optional<base::BodyDragParams> quadratic_;
};

}  // namespace cas::sim
