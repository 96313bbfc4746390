// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

#include "base/config/vehicle.hpp"
#include "fcu/control/pid.hpp"

namespace cas::fcu {

/// The part of a demand that the rotors achieve.
struct MixerResult {
  Eigen::Vector4d u = Eigen::Vector4d::Zero();         ///< U1 (N), U2, U3, U4 (N m) achieved
  Eigen::Vector4d omega_sq = Eigen::Vector4d::Zero();  ///< squared rotor speeds, rad^2/s^2
  Saturation thrust;                                   ///< up: no more U1, down: no less
  std::array<Saturation, 3> torque;                    ///< of U2, U3, U4
};

/// Brings U1..U4 within what the rotors can do: roll and pitch first, then thrust, yaw last.
///
/// Roll and pitch are kept whole as long as the span between slowest and fastest rotor suffices;
/// thrust moves as far as they need (on the ground only downwards); yaw gets the rest.
class Mixer {
 public:
  explicit Mixer(const base::Vehicle& vehicle);

  /// @param may_lift  whether roll and pitch may raise the thrust above the demand (in the air)
  MixerResult mix(const Eigen::Vector4d& demand, bool may_lift = true) const;
  /// Output 0..1 of each rotor: speed above idle over the span from idle to full.
  Eigen::Vector4d motor_outputs(const Eigen::Vector4d& omega_sq) const;
  /// U with all rotors at idle speed.
  Eigen::Vector4d idle() const;

  double max_thrust_n() const;

 private:
  Eigen::Matrix4d u_from_omega_sq_;
  Eigen::Matrix4d omega_sq_from_u_;
  double low_ = 0;   // slowest rotor, squared
  double high_ = 0;  // fastest rotor, squared
};

}  // namespace cas::fcu
