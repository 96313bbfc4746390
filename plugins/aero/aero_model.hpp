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
/// over it as rates of its own turn; each panel meets the air of its own place. Downwash of a wing
/// on the tail, wash of propellers, ground effect and the lag of lift are not modelled.
class AeroModel final : public ForceModel {
 public:
  explicit AeroModel(const base::AeroParams& params);

  /// Takes the outputs of the surfaces, held until the next call.
  void take(const MotorCommand& command) { servos_.take(command); }
  void release() { servos_.release(); }
  void set_health(const SurfaceHealth& health) { servos_.set_health(health); }

  /// Deflections of the surfaces, rad, in the order of the vehicle file.
  int state_count() const override { return static_cast<int>(servos_.count()); }
  void initial_states(std::span<double> x) const override { std::ranges::fill(x, 0.0); }
  void evaluate(const BodyState& body, const Environment& environment, std::span<const double> x,
                std::span<double> x_dot, Wrench& wrench) const override;
  void limit(std::span<double> x) const override { servos_.limit(x); }

 private:
  SurfaceServos servos_;
  std::optional<DerivativeBody> body_;
  std::vector<LiftingPanel> panels_;
};

}  // namespace cas::sim
