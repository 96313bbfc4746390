// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/rangefinder/rangefinder_model.hpp"

#include <cmath>

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
          .direction_B = sheet.direction_B};
}

RangeSample RangefinderModel::sample(base::SimTime time, std::optional<double> distance_m) {
  const double error = params_.stddev_m * random_();  // drawn also without a hit: a fixed stream
  RangeSample sample;
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
