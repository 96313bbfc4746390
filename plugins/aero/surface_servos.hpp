// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "base/config/vehicle.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/surface_health.hpp"

namespace cas::sim {

/// Servos of the control surfaces: each follows its target with a first-order lag and a fastest
/// rate. They have power before the motors do, so they follow a vehicle that is disarmed, too.
class SurfaceServos {
 public:
  SurfaceServos() = default;
  explicit SurfaceServos(std::span<const base::ControlSurface> surfaces)
      : surfaces_(surfaces.begin(), surfaces.end()) {}

  std::size_t count() const { return surfaces_.size(); }
  /// Control inputs U1..U4 and numbers that are not finite ask for 0.
  void take(const MotorCommand& command) {
    const bool outputs = command.kind == MotorCommand::Kind::kMotorOutputs;
    for (std::size_t i = 0; i < count(); ++i) {
      const Eigen::Index output = surfaces_[i].output;
      const double value = outputs && output < command.values.size() ? command.values[output] : 0.0;
      asked_[i] = std::isfinite(value) ? value : 0.0;
    }
    aim();
  }
  void set_health(const SurfaceHealth& health) {
    health_ = health;
    aim();
  }
  void release() {
    asked_.fill(0.0);
    aim();
  }

  /// @param angles  rad
  /// @param rates   rad/s
  void rates(std::span<const double> angles, std::span<double> rates) const {
    for (std::size_t i = 0; i < count(); ++i) {
      const base::ControlSurface& servo = surfaces_[i];
      const double fastest = health_.servos[i].rate_share * servo.rate_rad_s;
      rates[i] = std::clamp((targets_[i] - angles[i]) / servo.time_constant_s, -fastest, fastest);
    }
  }
  void limit(std::span<double> angles) const {
    for (std::size_t i = 0; i < count(); ++i) {
      const auto [low, high] = std::minmax(surfaces_[i].min_rad, surfaces_[i].max_rad);
      angles[i] = std::clamp(angles[i], low, high);
    }
  }

 private:
  void aim() {
    for (std::size_t i = 0; i < count(); ++i) {
      const ServoHealth& servo = health_.servos[i];
      targets_[i] =
          servo.held_rad.value_or(surfaces_[i].angle_rad(servo.reversed ? -asked_[i] : asked_[i]));
    }
  }

  std::vector<base::ControlSurface> surfaces_;
  SurfaceHealth health_;
  std::array<double, base::kMaxOutputs> asked_{};    // outputs
  std::array<double, base::kMaxOutputs> targets_{};  // rad
};

}  // namespace cas::sim
