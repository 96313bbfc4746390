// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/config/config.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/point_cloud.hpp"
#include "libsim/api/world.hpp"
#include "plugins/lidar/lidar_pattern.hpp"
#include "plugins/lidar/obstacle_sectors.hpp"

namespace cas::sim {

struct LidarParams {
  std::vector<LidarBeam> beams;
  std::optional<DepthPicture> picture{};  ///< of a depth camera
  double rate_hz = 0;                     ///< scans in a second
  double min_m = 0;                       ///< nearer and farther surfaces give no return
  double max_m = 0;
  double stddev_m = 0;      ///< white, of one distance
  double dropout = 0;       ///< share of the beams that are lost
  double least_cosine = 0;  ///< of the angle of incidence; a flatter beam gives no return
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_BS = Eigen::Quaterniond::Identity();
  std::optional<double> obstacle_height_m{};  ///< nullopt: no sectors
};

/// Reads the block `lidar`: its keys are those of its sheet (base/config/sensor_sheets.hpp).
LidarParams parse_lidar_params(const base::ConfigNode& node, double step_s);

/// One scan.
struct LidarScan {
  std::uint64_t number = 0;  ///< from 0
  base::SimTime begin;       ///< when its first beam fired
  Eigen::Vector3d p_WS;      ///< place of the sensor at that time
  Eigen::Quaterniond q_WS;   ///< and its attitude
  std::vector<CloudPoint> points;
  ObstacleSectors sectors;
};

/// Fires the beams of a pattern, scan after scan from time zero, each at its own time from where
/// the moving sensor is then. Other vehicles and obstacles stand where they are at the end of the
/// step. Width of a beam, reflectivity and multiple returns are not modelled.
class LidarModel {
 public:
  using OnScan = std::function<void(const LidarScan&)>;

  LidarModel() = default;
  /// @param on_scan  called with each whole scan
  LidarModel(LidarParams params, std::uint64_t seed, OnScan on_scan);

  /// Aims the beams that fire from `begin` on, before `end`.
  /// @param from, to  the vehicle at these times
  void aim(base::SimTime begin, base::SimTime end, const BodyState& from, const BodyState& to);
  /// Rays of the aimed beams, by origin and direction.
  std::span<const Eigen::Vector3d> origins_W() const { return origins_W_; }
  std::span<const Eigen::Vector3d> directions_W() const { return directions_W_; }
  /// Room for what the aimed beams meet.
  std::span<RayHit> hits() { return hits_; }
  /// Takes the hits of the aimed beams into the scan.
  void take_hits();

  const LidarParams& params() const { return params_; }
  std::uint64_t rays() const { return rays_; }
  std::uint64_t returns() const { return returns_; }

 private:
  /// An aimed beam.
  struct Shot {
    std::size_t beam;
    Eigen::Quaterniond q_WB;
  };

  double time_of(std::uint64_t scan, std::size_t beam) const {
    return (static_cast<double>(scan) + params_.beams[beam].share) / params_.rate_hz;
  }
  void take(const Shot& shot, const Eigen::Vector3d& origin_W, const Eigen::Vector3d& direction_W,
            const RayHit& hit);
  void see(const Shot& shot, const Eigen::Vector3d& direction_W,
           const std::optional<double>& distance_m);

  LidarParams params_;
  base::NormalRandom random_;
  OnScan on_scan_;
  std::uint64_t scan_number_ = 0;  // of the next beam
  std::size_t next_ = 0;           // beam
  std::vector<Shot> shots_;
  std::vector<Eigen::Vector3d> origins_W_;
  std::vector<Eigen::Vector3d> directions_W_;
  std::vector<RayHit> hits_;
  std::vector<BodyState>
      vehicles_;  // where the vehicle was at the beginning of the scans of a step
  LidarScan scan_;
  std::uint64_t rays_ = 0;
  std::uint64_t returns_ = 0;
};

}  // namespace cas::sim
