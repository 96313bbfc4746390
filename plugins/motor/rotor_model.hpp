// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/config/vehicle.hpp"
#include "libsim/api/world.hpp"
#include "plugins/motor/motor_circuit.hpp"
#include "plugins/motor/rotor_inflow.hpp"

namespace cas::sim {

/// The rotors: their speeds, and the tilt of those with a servo, are states that the world
/// integrates with the body.
///
/// Speeds follow their targets with a first-order lag, slower or faster downwards, or, where the
/// rotors have circuits, the motors' torque (MotorCircuit); battery and duties then belong to the
/// model. Each rotor adds,
/// at its hub and along its axis: thrust k_f w^2 and reaction torque k_m w^2 ([HILS] Eq. (1), (2)),
/// the reaction J_r dw/dt of its spin-up, the gyroscopic torque -w_body x H, in-plane drag -lambda
/// w v and the rolling moment of the advancing blade with airspeed v in the rotor plane; thrust
/// grows near the ground (Cheeseman and Bennett 1955) and with air density, and falls to zero at
/// the axial speed where the blades meet the air flat. The lower rotor of a coaxial pair loses
/// thrust as base::Wake says. Thrust and torque follow the inflow (rotor_inflow()) where a rotor
/// has an `inflow_thrust_slope`, and the advance ratio where it has a base::Propeller. Blades that
/// flap tilt the disc back by a = A v / (w R), with v / (w R) held at 1, and a stiff hub passes the
/// moment K a on, which lifts the nose in forward flight (G. M. Hoffmann, H. Huang, S. L.
/// Waslander, C. J. Tomlin, "Quadrotor helicopter flight dynamics and control: theory and
/// experiment", AIAA 2007-6461); the force of the tilted disc is a part of the in-plane drag. A
/// servo tilts the axis with a lag and a fastest rate; the rotor's angular momentum turns with it.
/// A `reversible` rotor that turns the other way pulls the other way, as strongly. A coefficient of
/// zero switches its effect off. Other interaction between rotors and the inertia of the tilted
/// parts are not modelled.
class RotorModel final : public ForceModel {
 public:
  explicit RotorModel(const base::Vehicle& vehicle);

  /// Speeds asked for, rad/s, one for each rotor, below 0 of `reversible` ones only; held until the
  /// next call.
  void set_targets(const base::RotorVector& omega) {
    copy(omega, targets_);
    if (circuit_) circuit_->set_targets(targets_);
  }
  base::RotorVector targets() const {
    return base::RotorVector::Map(targets_.data(), rotor_count());
  }
  /// Tilts asked for, rad, one for each rotor; those without a servo ignore theirs.
  void set_tilt_targets(const base::RotorVector& tilt_rad) { copy(tilt_rad, tilt_targets_); }
  /// Share of its thrust and torque that each rotor still gives (damaged blades), 0..1.
  void set_effectiveness(const base::RotorVector& share) { copy(share, effectiveness_); }
  /// Whether the battery and its states are this model's.
  bool has_circuit() const { return circuit_.has_value(); }
  /// Share of the battery's voltage that is left; for circuits.
  void set_voltage_share(double share) { circuit_->set_voltage_share(share); }
  /// Currents and voltage of the circuits, and the battery that feeds them.
  MotorCircuit::Supply supply(std::span<const double> x) const {
    return circuit_->solve(x.first(count_), battery_of(x), off_);
  }
  BatteryReading battery(const MotorCircuit::Supply& supply, std::span<const double> x) const {
    return circuit_->reading(supply, battery_of(x));
  }

  /// Stops a rotor at once and for good, as when it hits an obstacle; its angular momentum goes
  /// into the obstacle.
  void stop(std::size_t rotor) { stopped_[rotor] = off_[rotor] = true; }
  bool is_stopped(std::size_t rotor) const { return stopped_[rotor]; }
  void release_all() {
    stopped_.fill(false);
    off_.fill(false);
  }
  /// Circuits without current: their rotors coast, with friction and load, and drive nothing.
  void cut_currents(const std::array<bool, base::kMaxRotors>& cut) {
    for (std::size_t i = 0; i < count_; ++i) off_[i] = stopped_[i] || cut[i];
  }

  int rotor_count() const { return static_cast<int>(count_); }
  /// Speeds of the rotors, then tilts of the servos, then the circuits' battery.
  int state_count() const override {
    return static_cast<int>(count_ + servo_count_ + (circuit_ ? MotorCircuit::kStates : 0));
  }
  void initial_states(std::span<double> x) const override;
  void evaluate(const BodyState& body, const Environment& environment, std::span<const double> x,
                std::span<double> x_dot, Wrench& wrench) const override;
  void limit(std::span<double> x) const override;

  /// Power at the shaft of each rotor, W: k_m w^3, or by the inflow as evaluate() has it; not below
  /// 0, for a controller of a motor takes nothing back.
  base::RotorVector shaft_powers(const BodyState& body, const Environment& environment,
                                 std::span<const double> x) const;

  /// Thrust out of ground over thrust at height `height_m` of the hub: 1 / (1 - (R / 4 z)^2), held
  /// below z = R / 2 where the formula ends.
  static double ground_effect(double height_m, double radius_m);

 private:
  static constexpr std::size_t kMost = base::kMaxRotors;

  /// The air and the ground as the rotors meet them.
  struct Surroundings {
    Eigen::Vector3d v_air_B;  // of the centre of gravity through the air
    Eigen::Vector3d up_B;
    double air_density_kg_m3;
    double height_m;                                   // of the centre of gravity
    const Eigen::Matrix3d* wind_gradient_B = nullptr;  // 1/s, where the wind has one
  };
  /// One rotor; keeps the values that a step reads close together.
  struct Hub {
    Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d axis_B = Eigen::Vector3d::UnitZ();
    double spin = 1;
    base::RotorParams params;
    std::size_t upper = 0;  // the rotor above, where `wake_loss` is not 0
    double wake_loss = 0;   // share of its own thrust that a rotor above takes
  };
  struct Servo {
    std::size_t rotor = 0;
    base::TiltServo params;
  };
  /// A rotor at one stage of the integrator.
  struct Motion {
    double omega = 0;
    double omega_dot = 0;
    double upper_omega = 0;                                // of the rotor above
    Eigen::Vector3d axis_B = Eigen::Vector3d::UnitZ();     // where a servo holds it
    Eigen::Vector3d axis_dot_B = Eigen::Vector3d::Zero();  // and how fast it turns it, 1/s
  };

  /// Air past a hub: the part in the rotor's plane drags and rolls, the axial part takes thrust.
  struct HubAir {
    double height;  // of the hub
    double v_axial;
    Eigen::Vector3d v_plane_B;
  };
  /// Thrust along the axis and torque against the turning, N and N m.
  struct Load {
    double thrust;
    double torque;
  };

  template <class T>
  std::span<T> battery_of(std::span<T> x) const {
    return x.subspan(count_ + servo_count_);
  }
  void copy(const base::RotorVector& from, std::array<double, kMost>& to) const {
    for (int i = 0; i < std::min(rotor_count(), static_cast<int>(from.size())); ++i) {
      to[static_cast<std::size_t>(i)] = from[i];
    }
  }
  /// Velocity of a place r_B of the body through the air; a plain step's wind has no gradient.
  template <bool kPlain>
  [[gnu::always_inline]] static inline Eigen::Vector3d air_velocity_B(const Surroundings& around,
                                                                      const Eigen::Vector3d& w_WB_B,
                                                                      const Eigen::Vector3d& r_B);
  Surroundings surroundings(const BodyState& body, const Environment& environment) const;
  static Eigen::Matrix3d wind_gradient_B(const BodyState& body, const Environment& environment);
  static double lag(const base::RotorParams& params, double omega, double target);
  static double speed_derivative(const base::RotorParams& params, double omega, double target);
  [[gnu::always_inline]] static inline double thrust_factor(const base::RotorParams& params,
                                                            double axial_speed, double hub_height);
  /// w |w|, less in thin air and with broken blades.
  [[gnu::always_inline]] inline double dynamic_speed(std::size_t rotor, double omega,
                                                     double air_density_kg_m3) const;
  static double tilt_rate(const base::TiltServo& servo, double tilt, double target);
  RotorLoad inflow_load(std::size_t rotor, double omega, const Eigen::Vector3d& axis_B,
                        const Eigen::Vector3d& w_WB_B, const Surroundings& around) const;
  Motion motion(std::size_t rotor, std::span<const double> x, std::span<const double> x_dot) const;
  /// Torque on the motor's shaft: what a fault turns round still resists.
  double shaft_load(std::size_t rotor, double torque) const {
    return effectiveness_[rotor] < 0 ? -torque : torque;
  }
  template <bool kPlain>
  [[gnu::always_inline]] inline HubAir hub_air(std::size_t rotor, const Motion& motion,
                                               const Eigen::Vector3d& w_WB_B,
                                               const Surroundings& around) const;
  template <bool kPlain>
  [[gnu::always_inline]] inline Load load(std::size_t rotor, const Motion& motion,
                                          const HubAir& air, const Eigen::Vector3d& w_WB_B,
                                          const Surroundings& around) const;
  template <bool kPlain>
  void add_all(const Surroundings& around, const Eigen::Vector3d& w_WB_B, std::span<const double> x,
               std::span<double> x_dot, Wrench& wrench) const;
  // Asked 16 times a step for a quadrotor; within add_all a plain rotor's Motion is two numbers.
  template <bool kPlain>
  [[gnu::always_inline]] inline void add_rotor(std::size_t rotor, const Motion& motion,
                                               const HubAir& air, const Load& load,
                                               Wrench& wrench) const;

  std::size_t count_ = 0;
  std::size_t servo_count_ = 0;
  // No rotor leans, is in a wake, flaps, feels its inflow or has a circuit: each term of a step is
  // shorter.
  bool plain_ = true;
  std::array<Hub, kMost> hubs_;
  std::array<Servo, kMost> servos_;
  std::vector<std::optional<base::Propeller>> propellers_;  // of each rotor
  std::optional<MotorCircuit> circuit_;
  std::array<double, kMost> targets_{};
  std::array<double, kMost> tilt_targets_{};
  std::array<double, kMost> effectiveness_{};
  std::array<bool, kMost> stopped_{};
  std::array<bool, kMost> off_{};  // without current: stopped, or cut
};

}  // namespace cas::sim
