// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/config/vehicle.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/aero/derivative_body.hpp"
#include "plugins/aero/lifting_panel.hpp"
#include "plugins/aero/surface_servos.hpp"

namespace cas::sim {

/// The air's force and moment on wings, tail and body; the deflections of the control surfaces are
/// states that the world integrates with the body.
///
/// A body of derivatives meets the air as its reference point does, and feels how the wind changes
/// over it as rates of its own turn; each panel meets the air of its own place, a tail's also the
/// downwash of the wing, and one behind a propeller its wash, where the vehicle file says so.
/// Ground effect, the lag of lift, and the time that downwash takes to the tail are not modelled.
class AeroModel final : public ForceModel {
 public:
  /// @param rotors  of the vehicle, for their wash; without them panels meet none
  /// @throws base::ConfigError when a panel's polar cannot be read
  explicit AeroModel(const base::AeroParams& params, std::span<const base::Rotor> rotors = {});

  /// Takes the outputs of the surfaces, held until the next call.
  void take(const MotorCommand& command) { servos_.take(command); }
  void release() { servos_.release(); }
  /// Speeds of the rotors, whose wash is held until the next call.
  void set_rotor_speeds(const base::RotorVector& omega_rad_s) { omega_rad_s_ = omega_rad_s; }
  /// Whether a panel lies in the wash of a rotor.
  bool has_wash() const { return has_wash_; }
  void set_health(const SurfaceHealth& health) { servos_.set_health(health); }

  /// Deflections of the surfaces, rad, in the order of the vehicle file.
  int state_count() const override { return static_cast<int>(servos_.count()); }
  void initial_states(std::span<double> x) const override { std::ranges::fill(x, 0.0); }
  void evaluate(const BodyState& body, const Environment& environment, std::span<const double> x,
                std::span<double> x_dot, Wrench& wrench) const override;
  void limit(std::span<double> x) const override { servos_.limit(x); }

 private:
  /// How the air meets the vehicle: velocity through it at the centre, and its change by place.
  struct Flow {
    Eigen::Vector3d v_B;
    Eigen::Matrix3d turn_B;
    double density_kg_m3;
  };
  /// Velocity of a panel through the air, in the wash of its propeller.
  Eigen::Vector3d velocity_B(const LiftingPanel& panel, const Flow& flow) const;
  static void add(const LiftingPanel& panel, const Eigen::Vector3d& v_B, const Flow& flow,
                  std::span<const double> x, Wrench& wrench);

  SurfaceServos servos_;
  std::optional<DerivativeBody> body_;
  std::vector<LiftingPanel> panels_;  // those in the wing's downwash behind the others
  std::size_t in_clean_air_ = 0;
  double wing_span_m_ = 0;
  std::vector<base::Rotor> rotors_;
  bool has_wash_ = false;
  base::RotorVector omega_rad_s_;
};

}  // namespace cas::sim
