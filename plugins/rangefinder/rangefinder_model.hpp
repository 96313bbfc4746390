// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/config/config.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

struct RangefinderParams {
  double rate_hz = 0;
  double stddev_m = 0;  ///< white, one sample
  double min_m = 0;     ///< nearer and farther readings are invalid
  double max_m = 0;
  double lsb_m = 0;
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_B{0, 0, -1};  ///< unit vector
  double beam_rad = 0;                    ///< width of its cone; 0: a ray
};

/// Reads the block `rangefinder`: its keys are those of its sheet (base/config/sensor_sheets.hpp).
RangefinderParams parse_rangefinder_params(const base::ConfigNode& node, double step_s);

/// Directions of the rays that stand for a cone, unit, in B: evenly spread over it, the first along
/// its axis. One for a ray.
std::vector<Eigen::Vector3d> beam_directions_B(const RangefinderParams& params);

/// The nearest surface along a ray, or in a cone. Reflectivity is not modelled.
class RangefinderModel {
 public:
  RangefinderModel() = default;
  RangefinderModel(const RangefinderParams& params, std::uint64_t seed)
      : params_(params), random_(seed) {}

  /// @param distance_m  of the nearest surface; nullopt: no surface within max_m
  RangeSample sample(base::SimTime time, std::optional<double> distance_m);

  const RangefinderParams& params() const { return params_; }

 private:
  RangefinderParams params_;
  base::NormalRandom random_;
};

}  // namespace cas::sim
