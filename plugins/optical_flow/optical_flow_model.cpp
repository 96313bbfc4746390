// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/optical_flow/optical_flow_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "plugins/common/noise_params.hpp"

namespace cas::sim {

OpticalFlowParams parse_optical_flow_params(const base::ConfigNode& node, double step_s) {
  constexpr double kFarthest_m = 1000;
  constexpr double kLargest_rad_s = 100;
  OpticalFlowParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.stddev_rad_s = node.get_in("stddev_rad_s", 0.02, 1e-9, kLargest_rad_s);
  params.min_m = node.get_in("min_m", 0.08, 1e-3, kFarthest_m);
  params.max_m = node.get_in("max_m", 30, params.min_m, kFarthest_m);
  params.most_rad_s = node.get_in("most_rad_s", 7.4, 0.01, kLargest_rad_s);
  if (node.has("position_B_m")) {
    params.position_B_m = node.require<Eigen::Vector3d>("position_B_m");
  }
  return params;
}

void OpticalFlowModel::accumulate(const Eigen::Vector3d& v_D, const Eigen::Vector3d& w_D,
                                  std::optional<double> distance_m, double dt_s) {
  sum_.time_s += dt_s;
  sum_.turn_rad += w_D * dt_s;
  sum_.distance_m = distance_m && *distance_m >= params_.min_m ? distance_m : std::nullopt;
  if (!sum_.distance_m) return;
  const double d = *sum_.distance_m;
  const Eigen::Vector2d flow(w_D.x() - v_D.y() / d, w_D.y() + v_D.x() / d);
  if (flow.norm() > params_.most_rad_s) return;
  sum_.flow_rad += flow * dt_s;
  followed_s_ += dt_s;
}

FlowSample OpticalFlowModel::sample() {
  constexpr double kBest = 255;
  FlowSample sample = std::exchange(sum_, {});
  sum_.distance_m = sample.distance_m;
  const double share = sample.time_s > 0 ? followed_s_ / sample.time_s : 0;
  sample.quality = static_cast<std::uint8_t>(std::lround(kBest * std::min(share, 1.0)));
  // Two are drawn whatever is seen, so that the noise does not depend on the flight.
  const double x = random_();
  const double y = random_();
  if (sample.quality > 0) {
    sample.flow_rad += Eigen::Vector2d(x, y) * (params_.stddev_rad_s * followed_s_);
  }
  followed_s_ = 0;
  return sample;
}

}  // namespace cas::sim
