// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/lidar/lidar_model.hpp"

#include <cmath>
#include <utility>

#include "base/angles.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/sensor_sheets.hpp"
#include "base/earth/frames.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

/// Below this share of its length a direction is too steep to tell where it points.
constexpr double kSteepest = 0.2;

/// Where a moving vehicle is between two states. @param share  0: from, 1: to
BodyState between(const BodyState& from, const BodyState& to, double share) {
  BodyState state = from;
  state.p_WB += share * (to.p_WB - from.p_WB);
  state.q_WB = from.q_WB.slerp(share, to.q_WB);
  return state;
}

/// Clockwise from the vehicle's heading, rad.
double azimuth_of(const Eigen::Quaterniond& q_WB, const Eigen::Vector3d& v_W) {
  const Eigen::Vector3d nose_W = q_WB * Eigen::Vector3d::UnitX();
  return std::atan2(nose_W.y(), nose_W.x()) - std::atan2(v_W.y(), v_W.x());
}

}  // namespace

LidarParams parse_lidar_params(const base::ConfigNode& node, double step_s) {
  const base::LidarSheet sheet = base::read_lidar_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  const Eigen::Vector3d rpy = sheet.mounting_rpy_deg * base::kRadPerDeg;
  LidarPattern pattern = load_lidar_pattern(base::find_config(node.at("pattern")));
  if (sheet.cloud == base::CloudForm::kPgm && !pattern.picture) {
    node.at("cloud").fail("pgm needs the pattern of a depth camera, with a width and a height");
  }
  return {.beams = std::move(pattern.beams),
          .picture = pattern.picture,
          .rate_hz = sheet.rate_hz,
          .min_m = sheet.min_m,
          .max_m = sheet.max_m,
          .stddev_m = sheet.stddev_m,
          .dropout = sheet.dropout,
          .least_cosine = std::cos(sheet.max_incidence_deg * base::kRadPerDeg),
          .position_B_m = sheet.position_B_m,
          .q_BS = base::quaternion_rpy(rpy.x(), rpy.y(), rpy.z()),
          .obstacle_height_m = sheet.obstacle_height_m};
}

LidarModel::LidarModel(LidarParams params, std::uint64_t seed, OnScan on_scan)
    : params_(std::move(params)), random_(seed), on_scan_(std::move(on_scan)) {
  scan_.points.reserve(params_.beams.size());
}

void LidarModel::aim(base::SimTime begin, base::SimTime end, const BodyState& from,
                     const BodyState& to) {
  shots_.clear();
  vehicles_.clear();
  origins_W_.clear();
  directions_W_.clear();
  const double begin_s = base::to_seconds(begin);
  const double end_s = base::to_seconds(end);
  for (double fires_s = time_of(scan_number_, next_); fires_s < end_s;
       fires_s = time_of(scan_number_, next_)) {
    const BodyState vehicle = between(from, to, (fires_s - begin_s) / (end_s - begin_s));
    if (next_ == 0) vehicles_.push_back(vehicle);
    shots_.push_back({next_, vehicle.q_WB});
    origins_W_.push_back(vehicle.p_WB + vehicle.q_WB * params_.position_B_m);
    directions_W_.push_back(vehicle.q_WB * (params_.q_BS * params_.beams[next_].direction_S));
    if (++next_ < params_.beams.size()) continue;
    next_ = 0;
    ++scan_number_;
  }
  hits_.resize(shots_.size());
}

void LidarModel::take_hits() {
  std::size_t begun = 0;
  for (std::size_t i = 0; i < shots_.size(); ++i) {
    const Shot& shot = shots_[i];
    if (shot.beam == 0) {
      scan_.begin = base::SimTime(base::from_seconds(time_of(scan_.number, 0)));
      const BodyState& vehicle = vehicles_[begun++];
      scan_.p_WS = vehicle.p_WB + vehicle.q_WB * params_.position_B_m;
      scan_.q_WS = vehicle.q_WB * params_.q_BS;
    }
    take(shot, origins_W_[i], directions_W_[i], hits_[i]);
    if (shot.beam + 1 < params_.beams.size()) continue;
    on_scan_(scan_);
    scan_.points.clear();
    scan_.sectors.clear();
    ++scan_.number;
  }
}

/// Random numbers are drawn for each beam, so that what it meets changes those of no other.
void LidarModel::take(const Shot& shot, const Eigen::Vector3d& origin_W,
                      const Eigen::Vector3d& direction_W, const RayHit& hit) {
  ++rays_;
  const LidarBeam& beam = params_.beams[shot.beam];
  const double error_m = params_.stddev_m > 0 ? params_.stddev_m * random_() : 0;
  if (params_.dropout > 0 && random_.uniform() < params_.dropout) return;
  const double cosine = -hit.normal.dot(direction_W);
  const double distance_m = hit.distance_m + error_m;
  const bool returns =
      distance_m >= params_.min_m && distance_m <= params_.max_m && cosine >= params_.least_cosine;
  if (params_.obstacle_height_m) {
    see(shot, direction_W, returns ? std::optional(distance_m) : std::nullopt);
  }
  if (!returns) return;
  ++returns_;
  scan_.points.push_back({.p_S = (distance_m * beam.direction_S).cast<float>(),
                          .p_W = (origin_W + distance_m * direction_W).cast<float>(),
                          .cosine = static_cast<float>(cosine),
                          .time_s = static_cast<float>(beam.share / params_.rate_hz),
                          .ring = beam.ring});
}

void LidarModel::see(const Shot& shot, const Eigen::Vector3d& direction_W,
                     const std::optional<double>& distance_m) {
  const double level = direction_W.head<2>().norm();
  if (level < kSteepest) return;
  const double azimuth = azimuth_of(shot.q_WB, direction_W);
  if (distance_m && std::abs(*distance_m * direction_W.z()) <= *params_.obstacle_height_m) {
    scan_.sectors.see_obstacle(azimuth, *distance_m * level);
  } else {
    scan_.sectors.see_free(azimuth);
  }
}

}  // namespace cas::sim
