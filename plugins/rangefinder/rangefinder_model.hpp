// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/config/sensor_sheets.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

/// Directions of the rays that stand for a cone, unit, in B: evenly spread over it, the first along
/// its axis. One for a ray.
std::vector<Eigen::Vector3d> beam_directions_B(const base::RangefinderSheet& sheet);

/// The nearest surface along a ray, or in a cone. Reflectivity is not modelled.
class RangefinderModel {
 public:
  RangefinderModel() = default;
  RangefinderModel(const base::RangefinderSheet& sheet, std::uint64_t seed);

  /// @param distance_m  of the nearest surface; nullopt: no surface within max_m
  RangeSample sample(base::SimTime time, std::optional<double> distance_m);

  const base::RangefinderSheet& sheet() const { return sheet_; }

 private:
  base::RangefinderSheet sheet_;
  double stddev_m_ = 0;  ///< white, one sample
  base::NormalRandom random_;
};

}  // namespace cas::sim
