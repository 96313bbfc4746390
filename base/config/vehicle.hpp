// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "base/config/config.hpp"
#include "base/export.hpp"

namespace cas::base {

/// Rotors of every vehicle: quadrotors only.
inline constexpr int kRotors = 4;

/// One rotor of the airframe, numbered 1..4 in the file, 0..3 here.
struct RotorGeometry {
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();  ///< hub, from the centre of gravity, FLU
  int spin = 1;  ///< +1 counter-clockwise, -1 clockwise, seen from above
};

/// Coefficients common to the rotors. Zero switches an effect off; nothing has a default in the
/// file.
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
};

/// Full scales of HIL_CONTROLS: what +-1 (roll, pitch, yaw) and 1 (throttle) stand for.
struct ControlScales {
  double u1_max_n = 0;   ///< thrust at throttle 1
  double u2_max_nm = 0;  ///< roll moment at roll_ailerons 1
  double u3_max_nm = 0;  ///< pitch moment at pitch_elevator 1
  double u4_max_nm = 0;  ///< yaw moment at yaw_rudder 1
};

/// A battery whose voltage sags under load and falls with its charge; rotor speeds fall with it.
struct BatteryParams {
  double full_v = 0;          ///< at rest, charged
  double empty_v = 0;         ///< at rest, discharged
  double capacity_ah = 0;     ///< charge from full to empty
  double resistance_ohm = 0;  ///< inner resistance and leads
  double efficiency = 0;      ///< shaft power over electrical power
};

/// An airframe as config/vehicles/*.yaml describes it, for simulator and controller alike.
struct CAS_BASE_EXPORT Vehicle {
  std::string name;
  std::filesystem::path urdf;  ///< mass, inertia and shape; resolved against the YAML's folder
  double mass_kg = 0;          ///< repeated from the URDF for the controller; a test compares
  Eigen::Vector3d inertia_kg_m2 =
      Eigen::Vector3d::Zero();  ///< principal, about the centre of gravity
  std::array<RotorGeometry, kRotors> rotors;
  RotorParams rotor;
  ControlScales scales;
  double body_drag_linear_n_s_m = 0;         ///< fuselage drag, N per m/s of airspeed
  std::optional<BatteryParams> battery;      ///< nothing: the voltage never changes
  std::uint8_t system_id = 1;                ///< MAVLink system
  ConfigNode sensors = ConfigNode::empty();  ///< parameters by plugin name, see sensor_set()

  /// Reads a vehicle file. @throws ConfigError when a key is missing, unknown or out of range
  static Vehicle load(const std::filesystem::path& file);

  /// M of (U1, U2, U3, U4) = M * omega^2 (rad^2/s^2; N, N m) in the axes of D, from rotor positions
  /// and spins: [HILS] Eq. (3).
  Eigen::Matrix4d mixing_matrix() const;
};

}  // namespace cas::base
