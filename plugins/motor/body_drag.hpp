// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "libsim/api/world.hpp"

namespace cas::sim {

/// Drag of the fuselage at the centre of gravity: -c v, with v the velocity through the air. The
/// rotors' own drag is RotorModel's. Lift, and drag that differs by axis, are not modelled.
class BodyDrag final : public ForceModel {
 public:
  /// @param coefficient  c, N per m/s
  explicit BodyDrag(double coefficient) : coefficient_(coefficient) {}

  int state_count() const override { return 0; }
  void initial_states(std::span<double>) const override {}
  void evaluate(const BodyState& body, const Environment& environment, std::span<const double>,
                std::span<double>, Wrench& wrench) const override {
    const Eigen::Vector3d v_air_W = body.v_WB - environment.wind_W;
    wrench.force_B -= coefficient_ * (body.q_WB.conjugate() * v_air_W);
  }

 private:
  double coefficient_;
};

}  // namespace cas::sim
