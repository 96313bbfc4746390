// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/landing_target/landing_target_model.hpp"

#include <cmath>

#include "base/angles.hpp"
#include "base/earth/frames.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

/// Angles of a place in the picture, to the right and to the back. @param p_S  below the camera
Eigen::Vector2d angles_of(const Eigen::Vector3d& p_S) {
  return {std::atan2(-p_S.y(), -p_S.z()), std::atan2(-p_S.x(), -p_S.z())};
}

}  // namespace

LandingTargetParams parse_landing_target_params(const base::ConfigNode& node, double step_s) {
  constexpr double kFarthest_m = 1000;
  constexpr double kWidest_deg = 170;
  constexpr double kLargest_deg = 90;
  LandingTargetParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.max_m = node.require_in("max_m", 0.01, kFarthest_m);
  params.min_m = node.get_in("min_m", 0, 0, params.max_m);
  params.half_view_rad = {node.require_in("view_across_deg", 1, kWidest_deg) / 2,
                          node.require_in("view_along_deg", 1, kWidest_deg) / 2};
  params.half_view_rad *= base::kRadPerDeg;
  params.stddev_rad = node.get_in("stddev_deg", 0, 0, kLargest_deg) * base::kRadPerDeg;
  if (node.has("distance_stddev_m")) {
    params.stddev_m = node.require_in("distance_stddev_m", 0, kFarthest_m);
  }
  params.delay = base::from_seconds(node.get_in("delay_s", 0, 0, 10));
  if (node.has("position_B_m")) {
    params.position_B_m = node.require<Eigen::Vector3d>("position_B_m");
  }
  if (node.has("mounting_rpy_deg")) {
    const Eigen::Vector3d rpy =
        node.require<Eigen::Vector3d>("mounting_rpy_deg") * base::kRadPerDeg;
    params.q_BS = base::quaternion_rpy(rpy.x(), rpy.y(), rpy.z());
  }
  return params;
}

Eigen::Vector3d LandingTargetModel::eye_W(const BodyState& vehicle) const {
  return vehicle.p_WB + vehicle.q_WB * params_.position_B_m;
}

Eigen::Vector3d LandingTargetModel::from_eye_S(const BodyState& vehicle,
                                               const Eigen::Vector3d& p_W) const {
  return (vehicle.q_WB * params_.q_BS).conjugate() * (p_W - eye_W(vehicle));
}

bool LandingTargetModel::in_view(const Eigen::Vector3d& p_S) const {
  const double distance_m = p_S.norm();
  if (p_S.z() >= 0 || distance_m < params_.min_m || distance_m > params_.max_m) return false;
  return (angles_of(p_S).array().abs() <= params_.half_view_rad.array()).all();
}

/// Random numbers are drawn whatever is seen, so that the noise does not depend on the flight.
LandingTargetSample LandingTargetModel::sample(base::SimTime time, const Eigen::Vector3d& p_S,
                                               bool seen) {
  const double x = random_();
  const double y = random_();
  const double along = random_();
  LandingTargetSample sample;
  sample.time = time;
  sample.seen = seen;
  if (!seen) return sample;
  sample.angles_rad = angles_of(p_S) + params_.stddev_rad * Eigen::Vector2d(x, y);
  if (params_.stddev_m) sample.distance_m = std::max(p_S.norm() + *params_.stddev_m * along, 0.0);
  return sample;
}

}  // namespace cas::sim
