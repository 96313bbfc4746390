// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/config/aero.hpp"
#include "plugins/aero/panel_polar.hpp"

namespace cas::sim {

/// Coefficients of a panel at an angle of attack from anywhere; continuous, the same at +-180 deg.
///
/// Below the stall lift is linear, drag is C_D0 + |s a| + k C_L^2. Beyond, it is as the panel says:
/// - a blend (attached_share()) with a flat plate of normal force C sin a;
/// - straight lines, as of Gazebo Classic's plugin LiftDrag: lift falls to 0 and stays there, drag
///   is the size of its line. Air from behind counts as mirrored about 90 deg.
/// A surface shifts lift and moment by its deflection times the cosine of the angle.
///
/// @param angle_rad   of attack, from where the panel has no lift, -pi..pi
/// @param sin_angle   its sine
/// @param cos_angle   its cosine
/// @param deflection_rad  of the panel's surface
PanelCoefficients panel_coefficients(const base::PanelParams& panel, double angle_rad,
                                     double sin_angle, double cos_angle, double deflection_rad);

/// A panel in the air: only the flow at right angles to its span counts (simple sweep theory).
class LiftingPanel {
 public:
  LiftingPanel() = default;
  /// @throws base::ConfigError when its polar cannot be read
  explicit LiftingPanel(const base::PanelParams& params);

  const Eigen::Vector3d& position_B_m() const { return params_.position_B_m; }
  int surface() const { return params_.surface; }
  double downwash_share() const { return params_.downwash_share; }
  int in_wash_of() const { return params_.in_wash_of; }
  /// Adds the panel's force, which acts at its place, and its moment.
  /// @param v_B  of its place through the air, m/s
  void add(const Eigen::Vector3d& v_B, double air_density_kg_m3, double deflection_rad,
           Eigen::Vector3d& force_B, Eigen::Vector3d& torque_B) const;

 private:
  PanelCoefficients by_table(double angle_rad, double cos_angle, double deflection_rad,
                             double reynolds) const;

  base::PanelParams params_;
  PanelPolar polar_;                                   // empty: by slopes
  Eigen::Vector3d left_B_ = Eigen::Vector3d::UnitY();  // about which the nose goes down
  double cos_zero_lift_ = 1;
  double sin_zero_lift_ = 0;
};

}  // namespace cas::sim
