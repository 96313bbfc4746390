// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/rangefinder/rangefinder_model.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "base/angles.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {

std::vector<Eigen::Vector3d> beam_directions_B(const base::RangefinderSheet& sheet) {
  if (sheet.beam_deg == 0) return {sheet.direction_B};
  constexpr int kRays = 128;  // of a cone of 30 degrees less than 3 degrees apart
  const double golden = M_PI * (3 - std::sqrt(5.0));  // a turn by it is never repeated
  const double height = 1 - std::cos(sheet.beam_deg * base::kRadPerDeg / 2);
  const auto axis = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), sheet.direction_B);
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < kRays; ++i) {
    // Equal steps along the axis cut a sphere into rings of equal area.
    const double z = 1 - height * i / (kRays - 1);
    const double r = std::sqrt(1 - z * z);
    directions.emplace_back(axis *
                            Eigen::Vector3d(r * std::cos(golden * i), r * std::sin(golden * i), z));
  }
  return directions;
}

RangefinderModel::RangefinderModel(const base::RangefinderSheet& sheet, std::uint64_t seed)
    : sheet_(sheet), stddev_m_(white_noise(sheet.noise, 1.0, sheet.rate_hz).x()), random_(seed) {}

RangeSample RangefinderModel::sample(base::SimTime time, std::optional<double> distance_m) {
  const double error = stddev_m_ * random_();  // drawn also without a hit: a fixed stream
  RangeSample sample;
  sample.time = time;
  sample.min_m = sheet_.min_m;
  sample.max_m = sheet_.max_m;
  sample.direction_B = sheet_.direction_B;
  sample.beam_rad = sheet_.beam_deg * base::kRadPerDeg;
  sample.distance_m = distance_m ? *distance_m + error : sheet_.max_m;
  if (sheet_.lsb_m > 0) {
    sample.distance_m = std::round(sample.distance_m / sheet_.lsb_m) * sheet_.lsb_m;
  }
  sample.valid =
      distance_m && sample.distance_m >= sheet_.min_m && sample.distance_m <= sheet_.max_m;
  return sample;
}

}  // namespace cas::sim
