// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "base/config/vehicle.hpp"
#include "fcu/control/control_allocation.hpp"
#include "fcu/control/mixer_result.hpp"

namespace cas::fcu {

/// Actuator at an output of the autopilot.
enum class OutputKind : std::uint8_t { kNothing, kMotor, kServo };

/// Brings U1..U4 within the limits of the rotors: roll and pitch first, then thrust, yaw last.
///
/// Roll and pitch are kept whole as long as the span between slowest and fastest rotor suffices;
/// thrust moves as far as they need (on the ground only downwards); yaw gets the rest.
///
/// Four upright equal rotors are the quadrotor of [HILS]: the inverse of its Eq. (3), 4 x 4, as the
/// paper has it; the solution is unique and needs no weights. Any other vehicle is flown by
/// ControlAllocation, which gives the same for such four rotors up to rounding.
class Mixer {
 public:
  /// A vehicle without rotors has no output.
  /// @throws base::ConfigError when the rotors cannot give thrust, roll and pitch independently
  explicit Mixer(const base::Vehicle& vehicle);

  /// Whether a vehicle is flown by the inverse of [HILS] Eq. (3).
  static bool is_eq3(const base::Vehicle& vehicle);

  /// @param may_lift  whether roll and pitch may raise the thrust above the demand (in the air)
  /// @param side_D_n  force wanted along Dx and Dy beside the thrust, where side_force_n() > 0
  MixerResult mix(const Eigen::Vector4d& demand, bool may_lift = true,
                  const Eigen::Vector2d& side_D_n = Eigen::Vector2d::Zero()) const;
  /// All rotors at idle speed.
  MixerResult idle() const;

  /// On the wire, by output: each motor's speed above idle over its span from idle to full, 0..1;
  /// each servo's tilt, -1..1.
  std::array<double, base::kMaxOutputs> outputs(const MixerResult& result) const;
  OutputKind output_kind(std::size_t output) const { return kinds_[output]; }

  double max_thrust_n() const;
  /// Force that can be had in any direction sideways in hover, N; 0 where the rotors all point one
  /// way.
  double side_force_n() const { return side_force_n_; }

  /// Yaw moment in hover that can be counted on in both senses, N m: infinite where the rotors yaw
  /// the vehicle about equally well both ways, 0 where they yaw it one way only. Rotors without the
  /// other sense would turn it ever faster, if they were asked for a heading.
  double heading_torque_nm() const { return heading_torque_nm_; }

  /// Sets all rotors to leave out; a rotor that is not in `lost` is used again. @return false if
  /// the others cannot carry the vehicle: then nothing changes
  bool set_lost(RotorSet lost);
  RotorSet lost() const { return lost_; }

 private:
  MixerResult mix_eq3(const Eigen::Vector4d& demand, bool may_lift) const;
  Eigen::Vector4d idle_eq3() const;

  base::Vehicle vehicle_;
  std::array<OutputKind, base::kMaxOutputs> kinds_{};
  double hover_n_ = 0;
  double side_force_n_ = 0;
  double heading_torque_nm_ = std::numeric_limits<double>::infinity();
  RotorSet lost_ = 0;

  // Any rotors; not for those of Eq. (3).
  std::optional<ControlAllocation> allocation_;

  // The four of Eq. (3).
  Eigen::Matrix4d u_from_omega_sq_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d omega_sq_from_u_ = Eigen::Matrix4d::Zero();
  double low_ = 0;   // slowest rotor, squared
  double high_ = 0;  // fastest rotor, squared
};

}  // namespace cas::fcu
