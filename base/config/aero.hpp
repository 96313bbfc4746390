// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cas::base {

/// A control surface on a servo: aileron, elevator, rudder, flap. The signs of its effects are
/// those of the coefficients that name it.
struct ControlSurface {
  std::string name;
  int output = 0;              ///< of the autopilot, 0..15, -1..1 on it; in the file 1..16
  double min_rad = 0;          ///< deflection at output -1
  double max_rad = 0;          ///< deflection at output +1; of the other sign
  double rate_rad_s = 0;       ///< fastest turn
  double time_constant_s = 0;  ///< first-order lag; above 0

  /// Deflection that an output asks for: 0 at 0, straight lines to both ends.
  double angle_rad(double output_value) const {
    const double u = std::clamp(output_value, -1.0, 1.0);
    return u >= 0 ? u * max_rad : -u * min_rad;
  }
};

/// One coefficient of a body as a linear function of what it flies in, in the axes of D: angles of
/// attack and sideslip, body rates made dimensionless by b / 2V (p, r) and c / 2V (q), deflections.
struct CoefficientRow {
  double zero = 0;
  double alpha = 0;              ///< per rad
  double beta = 0;               ///< per rad
  double p = 0;                  ///< per p b / 2V
  double q = 0;                  ///< per q c / 2V
  double r = 0;                  ///< per r b / 2V
  std::vector<double> surfaces;  ///< per rad, one for each control surface
};

/// How lift and drag are put together from the rows.
enum class DerivativeForm : std::uint8_t {
  kBeard,  ///< induced drag of the lift by angle of attack; [Beard], Sect. 4.2
  kAvl,    ///< induced drag of all lift: Gazebo's advanced lift and drag, fed by AVL
};

/// A body described by stability derivatives about one point.
struct DerivativeParams {
  DerivativeForm form = DerivativeForm::kBeard;
  double area_m2 = 0;          ///< S
  double span_m = 0;           ///< b
  double chord_m = 0;          ///< c, mean aerodynamic
  double efficiency = 0;       ///< e, Oswald's
  double stall_rad = 0;        ///< angle of attack where half of the lift is a flat plate's
  double stall_sharpness = 0;  ///< M, 1/rad: the blend is some 4 / M wide
  Eigen::Vector3d centre_B_m = Eigen::Vector3d::Zero();  ///< that point, from the centre of gravity
  CoefficientRow lift, drag, side;
  CoefficientRow roll, pitch, yaw;

  double aspect_ratio() const { return span_m * span_m / area_m2; }
};

/// A part of a wing or tail that meets the air at a place of its own. Angles of attack count from
/// where it has no lift.
struct PanelParams {
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();  ///< of its aerodynamic centre, FLU
  Eigen::Vector3d normal_B = Eigen::Vector3d::UnitZ();     ///< upper side, unit
  Eigen::Vector3d forward_B = Eigen::Vector3d::UnitX();    ///< along the chord, unit
  double area_m2 = 0;
  double chord_m = 0;                 ///< 0: without moments of its own
  double zero_lift_rad = 0;           ///< angle of attack without lift
  double lift_slope_per_rad = 0;      ///< below the stall
  double stall_rad = 0;               ///< from where it has no lift
  double drag_zero = 0;               ///< drag coefficient without lift
  double drag_slope_per_rad = 0;      ///< further drag by the size of the angle of attack
  double induced_drag_factor = 0;     ///< 1 / (pi e AR) of the whole wing: times C_L^2
  double moment_zero = 0;             ///< about position_B_m, nose up
  double moment_slope_per_rad = 0;    ///< further moment by the sine of the angle of attack
  int surface = -1;                   ///< index of the control surface on it; -1: none
  double surface_lift_per_rad = 0;    ///< lift coefficient by its deflection
  double surface_moment_per_rad = 0;  ///< moment coefficient by its deflection
  // Beyond the stall: either straight lines, or a blend with a flat plate.
  bool blends = false;
  double after_stall_lift_slope_per_rad = 0;  ///< below 0: lift falls to 0 and stays there
  double after_stall_drag_slope_per_rad = 0;
  double stall_sharpness = 0;     ///< M, 1/rad, as of DerivativeParams
  double plate_normal_force = 0;  ///< coefficient of a plate across the air, 1.2 to 2
  std::filesystem::path polar{};  ///< table of coefficients instead of slopes; empty: none
  double downwash_share = 0;      ///< of the wing's downwash far behind it; 0: it meets clean air
  int in_wash_of = -1;            ///< index of the rotor whose wash it meets; -1: none
};

/// Block `aero` of a vehicle file: what makes it fly like a plane.
struct AeroParams {
  double cruise_m_s = 0;  ///< airspeed that `hilsim --describe` trims it at
  std::vector<ControlSurface> surfaces;
  std::optional<DerivativeParams> derivatives;
  std::vector<PanelParams> panels;
  double wing_span_m = 0;  ///< of the wing whose downwash panels meet; 0: none does
};

}  // namespace cas::base
