// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "base/config/vehicle.hpp"
#include "libsim/api/messages.hpp"

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
      targets_[i] = std::isfinite(value) ? surfaces_[i].angle_rad(value) : 0.0;
    }
  }
  void release() { targets_.fill(0.0); }

  /// @param angles  rad
  /// @param rates   rad/s
  void rates(std::span<const double> angles, std::span<double> rates) const {
    for (std::size_t i = 0; i < count(); ++i) {
      const base::ControlSurface& servo = surfaces_[i];
      rates[i] = std::clamp((targets_[i] - angles[i]) / servo.time_constant_s, -servo.rate_rad_s,
                            servo.rate_rad_s);
    }
  }
  void limit(std::span<double> angles) const {
    for (std::size_t i = 0; i < count(); ++i) {
      const auto [low, high] = std::minmax(surfaces_[i].min_rad, surfaces_[i].max_rad);
      angles[i] = std::clamp(angles[i], low, high);
    }
  }

 private:
  std::vector<base::ControlSurface> surfaces_;
  std::array<double, base::kMaxOutputs> targets_{};  // rad
};

}  // namespace cas::sim
