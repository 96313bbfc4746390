// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/config/aero.hpp"
#include "base/config/config.hpp"
#include "base/config/model_parts.hpp"
#include "base/config/propulsion.hpp"
#include "base/export.hpp"

namespace cas::base {

/// Most rotors of a vehicle: HIL_ACTUATOR_CONTROLS has 16 outputs.
inline constexpr int kMaxRotors = 16;
/// Outputs of an autopilot: those of HIL_ACTUATOR_CONTROLS.
inline constexpr int kMaxOutputs = 16;

/// Coefficients of a rotor: the file's block `rotor`, overlaid by the rotor's own keys. Zero
/// switches an effect off; nothing has a default in the file.
struct RotorParams {
  double thrust_coefficient = 0;          ///< k_f, N s^2, [HILS] Eq. (1)
  double torque_coefficient = 0;          ///< k_m, N m s^2, [HILS] Eq. (2)
  double omega_max_rad_s = 0;             ///< speed limit
  double omega_idle_rad_s = 0;            ///< slowest speed while armed
  double time_constant_up_s = 0;          ///< first-order lag, speeding up
  double time_constant_down_s = 0;        ///< first-order lag, slowing down
  double inertia_kg_m2 = 0;               ///< J_r, rotor and motor bell about the spin axis
  double radius_m = 0;                    ///< of the rotor disc
  double drag_coefficient = 0;            ///< in-plane drag, N per rad/s and m/s
  double rolling_moment_coefficient = 0;  ///< N m per rad/s and m/s
  double zero_thrust_speed_m_s = 0;       ///< axial airspeed at which thrust has faded to zero
  double reference_density_kg_m3 = 0;     ///< air in which k_f and k_m hold; 0: in any air
  double ground_effect = 0;               ///< share of Cheeseman and Bennett's thrust gain, 0..1
  // May be left out of the file: 0.
  double inflow_thrust_slope = 0;        ///< g = sigma a / (8 lambda_h): thrust over inflow
  double flapping_gain = 0;              ///< tilt of the disc over the advance ratio, rad
  double flapping_stiffness_nm_rad = 0;  ///< moment at the hub over the tilt of the disc
  double esc_dead_time_s = 0;            ///< from a command to the first change of the current
  bool reversible = false;  ///< outputs from -1 on turn it; thrust and torque change their signs
};

/// A servo that turns a rotor's axis: a tricopter's tail, a tiltrotor's wing rotors.
struct TiltServo {
  Eigen::Vector3d axis_B = Eigen::Vector3d::UnitX();  ///< hinge, a unit vector through the hub
  double min_rad = 0;          ///< tilt at output -1, about axis_B by the right hand; not above 0
  double max_rad = 0;          ///< tilt at output +1; not below 0
  double middle_rad = 0;       ///< tilt at output 0, from min_rad to max_rad
  double rate_rad_s = 0;       ///< fastest turn
  double time_constant_s = 0;  ///< first-order lag; above 0
  int output = 0;              ///< of the autopilot, 0..15, -1..1 on it; in the file 1..16

  /// Tilt that an output asks for: straight lines from the middle to both ends.
  double angle_rad(double output_value) const {
    const double u = std::clamp(output_value, -1.0, 1.0);
    return middle_rad + std::abs(u) * ((u >= 0 ? max_rad : min_rad) - middle_rad);
  }
  /// The output, -1..1, that asks for the tilt nearest to this one.
  double output_at(double tilt_rad) const {
    const double end_rad = tilt_rad >= middle_rad ? max_rad : min_rad;
    if (end_rad == middle_rad) return 0;
    const double share = (tilt_rad - middle_rad) / (end_rad - middle_rad);
    return std::copysign(std::min(share, 1.0), tilt_rad - middle_rad);
  }
};

/// A rotor below another one, in its slipstream: T = k_f w (w - (1 - thrust_share) w_upper), not
/// below 0. Blade-element theory: thrust falls linearly with the air that comes from above, which
/// is as fast as the upper rotor turns (Leishman, Principles of Helicopter Aerodynamics, 2nd ed.,
/// Sect. 3.2 and 2.15). Its torque stays k_m w^2, and the upper rotor does not feel it.
struct Wake {
  int upper = 0;            ///< index of the rotor above
  double thrust_share = 1;  ///< of its own thrust that is left when both turn equally fast, 0..1
};

/// One rotor, numbered 1..16 in files and texts, 0..15 here.
struct CAS_BASE_EXPORT Rotor {
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();  ///< hub, from the centre of gravity, FLU
  Eigen::Vector3d axis_B = Eigen::Vector3d::UnitZ();  ///< direction of thrust, unit; without tilt
  int spin = 1;    ///< +1 counter-clockwise, -1 clockwise, seen against axis_B from its tip
  int output = 0;  ///< of the autopilot, 0..15, 0..1 on it; in the file 1..16: its number if none
  RotorParams params;
  std::optional<Wake> wake;       ///< the lower rotor of a coaxial pair
  std::optional<TiltServo> tilt;  ///< nullopt: the axis is fixed
  /// Thrust and torque by advance ratio; k_f and k_m are then its own in still air.
  std::optional<Propeller> propeller;
  /// nullopt: the speed follows its target with a lag. Of all rotors or none; the lag and the
  /// fastest speed in `params` are then the circuit's in hover and at full output.
  std::optional<ElectricMotor> electric;

  /// Direction of thrust with the servo at `tilt_rad`; axis_B without a servo.
  Eigen::Vector3d tilted_axis_B(double tilt_rad) const;
  /// Speed that an output asks for, rad/s: idle + u (max - idle); with a circuit, that at which it
  /// settles in still air by a full battery, the duty being idle + u (1 - idle).
  /// @param output_value  0..1, from -1 where `reversible`
  double speed_at(double output_value) const;
  /// The output that asks for a speed; beyond [0, 1] where none does.
  double output_at(double omega_rad_s) const;
};

/// One value for each rotor; no heap.
using RotorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRotors, 1>;

/// Force and moment about the centre of gravity (FLU) of each rotor's omega^2: N s^2, N m s^2.
using Effectiveness = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxRotors>;

/// Full scales of HIL_CONTROLS: values of +-1 (roll, pitch, yaw) and 1 (throttle).
struct ControlScales {
  double u1_max_n = 0;   ///< thrust at throttle 1
  double u2_max_nm = 0;  ///< roll moment at roll_ailerons 1
  double u3_max_nm = 0;  ///< pitch moment at pitch_elevator 1
  double u4_max_nm = 0;  ///< yaw moment at yaw_rudder 1
};

/// Drag of the fuselage that grows with the square of the airspeed: -1/2 rho |v| (A_x v_x, A_y v_y,
/// A_z v_z), with v of the place where it acts.
struct BodyDragParams {
  Eigen::Vector3d area_m2 = Eigen::Vector3d::Zero();  ///< A = C_d S of air along forward, left, up
  Eigen::Vector3d centre_B_m =
      Eigen::Vector3d::Zero();  ///< of pressure, from the centre of gravity
};

/// An airframe as config/vehicles/*.yaml describes it, for simulator and controller alike.
struct CAS_BASE_EXPORT Vehicle {
  std::string name;
  std::filesystem::path
      urdf;            ///< the body's model, a URDF or SDF file; resolved against the YAML's folder
  double mass_kg = 0;  ///< rotors included; the file's, or the model's
  Eigen::Vector3d inertia_kg_m2 =
      Eigen::Vector3d::Zero();        ///< Ixx, Iyy, Izz about the centre of gravity
  std::vector<Rotor> rotors;          ///< 1 to kMaxRotors
  ControlScales scales;               ///< computed by control_scales() where the file has none
  double body_drag_linear_n_s_m = 0;  ///< fuselage drag, N per m/s of airspeed
  std::optional<BodyDragParams> body_drag;   ///< nullopt: none with the square of the airspeed
  std::optional<BatteryParams> battery;      ///< nullopt: the voltage never changes
  std::optional<AeroParams> aero;            ///< nullopt: no wings
  std::uint8_t system_id = 1;                ///< MAVLink system
  ConfigNode sensors = ConfigNode::empty();  ///< parameters by plugin name, see sensor_set()
  ModelParts parts;  ///< of the model: those of the file, and turning links that are no rotors
  /// What was taken otherwise than the files say, a sentence each; the model's own warnings are
  /// with whoever reads its shapes.
  std::vector<std::string> warnings;

  /// Reads a vehicle file and takes missing values from the model. Values in both must agree.
  /// @throws ConfigError when keys are missing (all of them in one sentence), unknown or out of
  ///         range, and when file and model differ (both values, both lines)
  static Vehicle load(const std::filesystem::path& file);

  /// Number of rotors, 1 to kMaxRotors.
  int rotor_count() const { return static_cast<int>(rotors.size()); }

  /// Column i: wrench of rotor i per omega_i^2 (force along its axis, its moment about the centre
  /// of gravity and its reaction torque), coaxial pairs turning equally fast, air at the reference
  /// density. Thrust fading and ground effect are left out.
  /// @param tilt_rad  one for each rotor, ignored for rotors without a servo; empty: no tilt
  Effectiveness effectiveness(std::span<const double> tilt_rad = {}) const;

  /// The lag of each rotor with a circuit: about its speed in hover, or at full output where the
  /// rotors cannot carry the vehicle.
  void settle_lags();

  /// The most that the rotors give on each axis of (U1, U2, U3, U4) alone, from effectiveness().
  ControlScales control_scales() const;

  /// Output u, the same for all rotors, 0..1, at which their upward thrust in still air carries the
  /// weight; a rotor turns at speed_at(u). nullopt where they cannot carry it.
  std::optional<double> hover_output(double gravity_m_s2) const;

  /// M of (U1, U2, U3, U4) = M * omega^2 (rad^2/s^2; N, N m) in the axes of D, from rotor positions
  /// and spins: [HILS] Eq. (3). For four rotors; others use effectiveness().
  Eigen::Matrix4d mixing_matrix() const;
};

}  // namespace cas::base
