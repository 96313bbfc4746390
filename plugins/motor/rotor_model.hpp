// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "base/config/vehicle.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

/// Four rotors: their speeds are states that the world integrates with the body.
///
/// Speeds follow their targets with a first-order lag, slower or faster downwards. Each rotor adds,
/// at its hub: thrust k_f w^2 and reaction torque k_m w^2 ([HILS] Eq. (1), (2)), the reaction
/// J_r dw/dt of its spin-up, the gyroscopic torque -w_body x H, in-plane drag -lambda w v and the
/// rolling moment of the advancing blade with airspeed v in the rotor plane; thrust grows near the
/// ground (Cheeseman and Bennett 1955) and with air density, and falls to zero at the axial speed
/// where the blades meet the air flat. A coefficient of zero switches its effect off. Blade
/// flapping and the interaction between rotors are not modelled.
class RotorModel final : public ForceModel {
 public:
  explicit RotorModel(const base::Vehicle& vehicle);

  /// Speeds asked for, rad/s, non-negative; held until the next call.
  void set_targets(const Eigen::Vector4d& omega) { targets_ = omega; }
  const Eigen::Vector4d& targets() const { return targets_; }
  /// Share of its thrust and torque that each rotor still gives (damaged blades), 0..1.
  void set_effectiveness(const Eigen::Vector4d& share) { effectiveness_ = share; }

  /// Stops a rotor at once and for good, as one that hits something; its spin goes into what it
  /// hit.
  void stop(std::size_t rotor) { stopped_[rotor] = true; }
  bool is_stopped(std::size_t rotor) const { return stopped_[rotor]; }
  void release_all() { stopped_.fill(false); }

  int state_count() const override { return base::kRotors; }
  void initial_states(std::span<double> omega) const override;
  void evaluate(const BodyState& body, const Environment& environment,
                std::span<const double> omega, std::span<double> omega_dot,
                Wrench& wrench) const override;
  void limit(std::span<double> omega) const override;

  /// Thrust out of ground over thrust at height `height_m` of the hub: 1 / (1 - (R / 4 z)^2), held
  /// below z = R / 2 where the formula ends.
  static double ground_effect(double height_m, double radius_m);

 private:
  /// The air and the ground as the rotors meet them.
  struct Surroundings {
    Eigen::Vector3d v_air_B;  // of the centre of gravity through the air
    Eigen::Vector3d up_B;
    double density_factor;  // over the density in which the coefficients hold
    double height_m;        // of the centre of gravity
  };

  Surroundings surroundings(const BodyState& body, const Environment& environment) const;
  double speed_derivative(double omega, double target) const;
  double thrust_factor(double axial_speed, double hub_height) const;
  void add_rotor(std::size_t rotor, double omega, double omega_dot, const Eigen::Vector3d& w_WB_B,
                 const Surroundings& around, Wrench& wrench) const;

  base::RotorParams params_;
  std::array<base::RotorGeometry, base::kRotors> rotors_;
  Eigen::Vector4d targets_ = Eigen::Vector4d::Zero();
  Eigen::Vector4d effectiveness_ = Eigen::Vector4d::Ones();
  std::array<bool, base::kRotors> stopped_{};
};

}  // namespace cas::sim
