// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "base/config/vehicle.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

/// Force and moment of a body that base::DerivativeParams describe.
///
/// Below the stall: [Beard] Sect. 4.2, or Gazebo's advanced lift and drag (form `avl`). Beyond, the
/// wing becomes a flat plate by attached_share(): lift 2 sgn(a) sin^2 a cos a, drag C sin^2 a with
/// C of a plate of this aspect ratio; derivatives by angle of attack go on with its sine, and the
/// surfaces' effect with its cosine, so that air from behind turns it round.
///
/// Sideslip counts as v / V, the sine of beta. What depends on angle of attack and deflections
/// takes the air's speed in the plane of symmetry, which fades as the air comes from the side. So
/// force and moment are finite and continuous in air from anywhere and at rest. In flight without
/// sideslip this is the linear form; its derivatives by beta there are the same.
class DerivativeBody {
 public:
  DerivativeBody() = default;
  explicit DerivativeBody(const base::DerivativeParams& params);

  /// @param v_B       of the reference point through the air, m/s
  /// @param w_B       angular velocity with respect to the air, rad/s
  /// @param angles    deflections, rad
  /// @return about the centre of gravity
  Wrench wrench(const Eigen::Vector3d& v_B, const Eigen::Vector3d& w_B, double air_density_kg_m3,
                std::span<const double> angles) const;
  const Eigen::Vector3d& centre_B_m() const { return centre_B_m_; }

 private:
  /// A row with its rates already multiplied by half of span or chord.
  struct Row {
    double zero, alpha, beta, p, q, r;
    std::array<double, base::kMaxOutputs> surfaces;
  };
  static Row row_of(const base::CoefficientRow& row, double span_m, double chord_m);

  base::DerivativeForm form_ = base::DerivativeForm::kBeard;
  double area_m2_ = 0;
  double span_m_ = 0;
  double chord_m_ = 0;
  double induced_factor_ = 0;  // 1 / (pi e AR)
  double plate_drag_ = 0;      // of a flat plate across the air
  double stall_rad_ = 0;
  double stall_sharpness_ = 0;
  Eigen::Vector3d centre_B_m_ = Eigen::Vector3d::Zero();
  Row lift_{}, drag_{}, side_{};
  Row roll_{}, pitch_{}, yaw_{};
};

}  // namespace cas::sim
