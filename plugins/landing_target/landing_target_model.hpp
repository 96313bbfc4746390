// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "base/config/config.hpp"
#include "base/random.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

struct LandingTargetParams {
  double rate_hz = 0;                ///< pictures in a second
  double max_m = 0;                  ///< a farther beacon is not found
  double min_m = 0;                  ///< nor is a nearer one
  Eigen::Vector2d half_view_rad{};   ///< of the picture, to the right and to the back
  double stddev_rad = 0;             ///< white, of each angle
  std::optional<double> stddev_m{};  ///< white, of the distance; nullopt: it is not measured
  base::Duration delay{};            ///< from a picture to its message
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_BS = Eigen::Quaterniond::Identity();
};

/// Reads the plugin's keys (docs/use/plugins.md).
LandingTargetParams parse_landing_target_params(const base::ConfigNode& node, double step_s);

/// A camera that finds a beacon in its picture. It looks along -Sz of its case, whose axes are
/// those of the vehicle (forward, left, up) without a mounting; the picture's x is to the right,
/// its y to the back, as PX4 (LTEST_SENS_ROT 2) and ArduPilot (PLND_YAW_ALIGN 0) take it.
///
/// The beacon is a point: its size, brightness and the sun are not modelled.
class LandingTargetModel {
 public:
  LandingTargetModel() = default;
  LandingTargetModel(const LandingTargetParams& params, std::uint64_t seed)
      : params_(params), random_(seed) {}

  /// Place of the camera in W. @param vehicle  its motion
  Eigen::Vector3d eye_W(const BodyState& vehicle) const;
  /// From the camera to a place in W, in the axes of its case S, m.
  Eigen::Vector3d from_eye_S(const BodyState& vehicle, const Eigen::Vector3d& p_W) const;
  /// Whether the picture shows the place, and it is in range.
  /// @param p_S  of from_eye_S()
  bool in_view(const Eigen::Vector3d& p_S) const;

  /// One picture. @param p_S  of from_eye_S() @param seen  it is in view and nothing hides it
  LandingTargetSample sample(base::SimTime time, const Eigen::Vector3d& p_S, bool seen);

  const LandingTargetParams& params() const { return params_; }

 private:
  LandingTargetParams params_;
  base::NormalRandom random_;
};

}  // namespace cas::sim
