// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/rangefinder/rangefinder_model.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "base/angles.hpp"
#include "base/config/sensor_sheets.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {

RangefinderParams parse_rangefinder_params(const base::ConfigNode& node, double step_s) {
  const base::RangefinderSheet sheet = base::read_rangefinder_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  return {.rate_hz = sheet.rate_hz,
          .stddev_m = white_noise(sheet.noise, 1.0, sheet.rate_hz).x(),
          .min_m = sheet.min_m,
          .max_m = sheet.max_m,
          .lsb_m = sheet.lsb_m,
          .position_B_m = sheet.position_B_m,
          .direction_B = sheet.direction_B,
          .beam_rad = sheet.beam_deg * base::kRadPerDeg};
}

std::vector<Eigen::Vector3d> beam_directions_B(const RangefinderParams& params) {
  if (params.beam_rad == 0) return {params.direction_B};
  constexpr int kRays = 128;  // of a cone of 30 degrees less than 3 degrees apart
  const double golden = M_PI * (3 - std::sqrt(5.0));  // a turn by it is never repeated
  const double height = 1 - std::cos(params.beam_rad / 2);
  const auto axis =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), params.direction_B);
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

RangeSample RangefinderModel::sample(base::SimTime time, std::optional<double> distance_m) {
  const double error = params_.stddev_m * random_();  // drawn also without a hit: a fixed stream
  RangeSample sample;
  sample.time = time;
  sample.min_m = params_.min_m;
  sample.max_m = params_.max_m;
  sample.direction_B = params_.direction_B;
  sample.beam_rad = params_.beam_rad;
  sample.distance_m = distance_m ? *distance_m + error : params_.max_m;
  if (params_.lsb_m > 0) {
    sample.distance_m = std::round(sample.distance_m / params_.lsb_m) * params_.lsb_m;
  }
  sample.valid =
      distance_m && sample.distance_m >= params_.min_m && sample.distance_m <= params_.max_m;
  return sample;
}

}  // namespace cas::sim
