// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "base/config/config.hpp"
#include "base/random.hpp"
#include "libsim/api/messages.hpp"

namespace cas::sim {

struct OpticalFlowParams {
  double rate_hz = 0;
  double stddev_rad_s = 0;  ///< white noise of the mean flow of one sample
  double min_m = 0;         ///< nearer and farther ground gives no flow
  double max_m = 0;
  double most_rad_s = 0;  ///< faster flow is not followed
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
};

/// Reads the plugin's keys (docs/use/plugins.md).
OpticalFlowParams parse_optical_flow_params(const base::ConfigNode& node, double step_s);

/// A camera that looks along Dz: the motion of the ground at the middle of the picture, as a
/// right-handed turn of the camera would cause it ([MAVLink] HIL_OPTICAL_FLOW).
///
/// The flow is w_x - v_y / d about Dx and w_y + v_x / d about Dy, with the velocity v of the camera
/// over ground that stands still and the distance d along its axis; while it is not followed, the
/// integral has no part of it. Texture, light and the picture's edges are not modelled.
class OpticalFlowModel {
 public:
  OpticalFlowModel() = default;
  OpticalFlowModel(const OpticalFlowParams& params, std::uint64_t seed)
      : params_(params), random_(seed) {}

  /// Takes in a step. @param v_D  of the camera, m/s @param w_D  rad/s
  /// @param distance_m  along Dz; nullopt: no ground within max_m
  void accumulate(const Eigen::Vector3d& v_D, const Eigen::Vector3d& w_D,
                  std::optional<double> distance_m, double dt_s);
  /// The sums since the last call, with noise.
  FlowSample sample();

  const OpticalFlowParams& params() const { return params_; }

 private:
  OpticalFlowParams params_;
  base::NormalRandom random_;
  FlowSample sum_;
  double followed_s_ = 0;
};

}  // namespace cas::sim
