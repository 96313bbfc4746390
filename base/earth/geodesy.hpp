// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "base/export.hpp"

namespace cas::base {

/// A place on Earth: degrees, metres above mean sea level.
struct Geodetic {
  double lat_deg = 0;
  double lon_deg = 0;
  double alt_m = 0;
};

/// Shape of the Earth that a LocalProjection uses.
enum class EarthModel { kSphere, kWgs84 };

/// Maps local north-east-down positions (m) about a home to latitude and longitude, and back.
///
/// kSphere is the great-circle projection of [HILS] Eq. (5) with atan2 (radius 6 371 000 m), which
/// is also the projection PX4 uses; kWgs84 is the ellipsoid's tangent plane through ECEF.
class CAS_BASE_EXPORT LocalProjection {
 public:
  LocalProjection() = default;
  LocalProjection(const Geodetic& home, EarthModel model = EarthModel::kSphere);

  /// @param p_N  from home, north-east-down, m
  Geodetic to_geodetic(const Eigen::Vector3d& p_N) const;
  /// @return from home, north-east-down, m
  Eigen::Vector3d to_local(const Geodetic& place) const;
  /// Origin of N.
  const Geodetic& home() const { return home_; }

 private:
  Geodetic home_;
  EarthModel model_ = EarthModel::kSphere;
};

}  // namespace cas::base
