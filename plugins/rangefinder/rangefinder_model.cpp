// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/rangefinder/rangefinder_model.hpp"

#include <cmath>

#include "plugins/common/noise_params.hpp"

namespace cas::sim {

RangefinderParams parse_rangefinder_params(const base::ConfigNode& node, double step_s) {
  constexpr double kFarthest = 10'000;
  RangefinderParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.stddev_m = parse_white_noise(node, {"", "m", 1.0}, params.rate_hz).x();
  params.min_m = node.require_in("min_m", 0, kFarthest);
  params.max_m = node.require_in("max_m", params.min_m, kFarthest);
  params.lsb_m = node.get_in("lsb_m", 0, 0, 10);
  params.position_B_m = get_axes(node, "position_B_m");
  if (const auto direction = node.find("direction_B")) {
    params.direction_B = direction->as<Eigen::Vector3d>();
    if (params.direction_B.norm() < 1e-6) direction->fail("must not be zero");
    params.direction_B.normalize();
  }
  return params;
}

RangeSample RangefinderModel::sample(base::SimTime time, std::optional<double> distance_m) {
  const double error = params_.stddev_m * random_();  // drawn anyway: the stream does not depend on
  RangeSample sample;                                 // what the ray meets
  sample.time = time;
  sample.min_m = params_.min_m;
  sample.max_m = params_.max_m;
  sample.direction_B = params_.direction_B;
  sample.distance_m = distance_m ? *distance_m + error : params_.max_m;
  if (params_.lsb_m > 0) {
    sample.distance_m = std::round(sample.distance_m / params_.lsb_m) * params_.lsb_m;
  }
  sample.valid =
      distance_m && sample.distance_m >= params_.min_m && sample.distance_m <= params_.max_m;
  return sample;
}

}  // namespace cas::sim
