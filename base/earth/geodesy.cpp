// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/geodesy.hpp"

#include <algorithm>
#include <cmath>

#include "base/angles.hpp"
#include "base/earth/wgs84.hpp"

namespace cas::base {
namespace {

using wgs84::kEccentricity2;
using wgs84::kFlattening;
using wgs84::kSemiMajor_m;

constexpr double kSphereRadius = 6'371'000.0;  // m, mean radius, as PX4's projection uses

double wrap_lon_deg(double lon_deg) { return std::remainder(lon_deg, 360.0); }

// [HILS] Eq. (5). With atan2 it holds beyond a quarter of the globe; rho = 0 is its own case.
Geodetic sphere_to_geodetic(const Geodetic& home, const Eigen::Vector3d& p_N) {
  const double x = p_N.x();
  const double y = p_N.y();
  const double rho = std::hypot(x, y);
  const double alt_m = home.alt_m - p_N.z();
  if (rho == 0.0) return {home.lat_deg, home.lon_deg, alt_m};
  const double c = rho / kSphereRadius;
  const double lat_0 = home.lat_deg * kRadPerDeg;
  const double sin_lat = std::cos(c) * std::sin(lat_0) + x / rho * std::sin(c) * std::cos(lat_0);
  const double d_lon = std::atan2(
      y * std::sin(c), rho * std::cos(c) * std::cos(lat_0) - x * std::sin(c) * std::sin(lat_0));
  return {std::asin(std::clamp(sin_lat, -1.0, 1.0)) * kDegPerRad,
          wrap_lon_deg(home.lon_deg + d_lon * kDegPerRad), alt_m};
}

// Inverse of sphere_to_geodetic: the azimuthal equidistant projection. The haversine keeps
// millimetres where an arc cosine would lose them.
Eigen::Vector3d sphere_to_local(const Geodetic& home, const Geodetic& place) {
  const double lat_0 = home.lat_deg * kRadPerDeg;
  const double lat = place.lat_deg * kRadPerDeg;
  const double d_lon = (place.lon_deg - home.lon_deg) * kRadPerDeg;
  const double sin_dlat = std::sin((lat - lat_0) / 2.0);
  const double sin_dlon = std::sin(d_lon / 2.0);
  const double a = sin_dlat * sin_dlat + std::cos(lat_0) * std::cos(lat) * sin_dlon * sin_dlon;
  const double c = 2.0 * std::atan2(std::sqrt(a), std::sqrt(std::max(0.0, 1.0 - a)));
  // north and east parts of sin(c); the north part with the small differences kept apart
  const double north =
      std::sin(lat - lat_0) + 2.0 * std::sin(lat_0) * std::cos(lat) * sin_dlon * sin_dlon;
  const double east = std::cos(lat) * std::sin(d_lon);
  const double sin_c = std::hypot(north, east);
  const double scale = sin_c == 0.0 ? 0.0 : kSphereRadius * c / sin_c;
  return {north * scale, east * scale, home.alt_m - place.alt_m};
}

double prime_vertical_radius(double sin_lat) {
  return kSemiMajor_m / std::sqrt(1.0 - kEccentricity2 * sin_lat * sin_lat);
}

/// Earth-centred, earth-fixed coordinates, m.
Eigen::Vector3d to_ecef(const Geodetic& place) {
  const double lat = place.lat_deg * kRadPerDeg;
  const double lon = place.lon_deg * kRadPerDeg;
  const double n = prime_vertical_radius(std::sin(lat));
  return {(n + place.alt_m) * std::cos(lat) * std::cos(lon),
          (n + place.alt_m) * std::cos(lat) * std::sin(lon),
          (n * (1.0 - kEccentricity2) + place.alt_m) * std::sin(lat)};
}

// Bowring's method (1976, 1985): the parametric latitude iterated; two rounds reach the nanometre
// near the ground.
Geodetic from_ecef(const Eigen::Vector3d& p_E) {
  const double b = kSemiMajor_m * (1.0 - kFlattening);
  const double second_eccentricity2 = kEccentricity2 / (1.0 - kEccentricity2);
  const double r = std::hypot(p_E.x(), p_E.y());
  double beta = std::atan2(p_E.z(), (1.0 - kFlattening) * r);
  double lat = 0.0;
  for (int round = 0; round < 4; ++round) {
    const double s = std::sin(beta);
    const double c = std::cos(beta);
    lat = std::atan2(p_E.z() + second_eccentricity2 * b * s * s * s,
                     r - kEccentricity2 * kSemiMajor_m * c * c * c);
    beta = std::atan2((1.0 - kFlattening) * std::sin(lat), std::cos(lat));
  }
  const double sin_lat = std::sin(lat);
  const double n = prime_vertical_radius(sin_lat);
  const double alt_m = r * std::cos(lat) + p_E.z() * sin_lat - kSemiMajor_m * kSemiMajor_m / n;
  return {lat * kDegPerRad, std::atan2(p_E.y(), p_E.x()) * kDegPerRad, alt_m};
}

/// Rotates ECEF vectors into N at `home`.
Eigen::Matrix3d rotation_NE(const Geodetic& home) {
  const double sin_lat = std::sin(home.lat_deg * kRadPerDeg);
  const double cos_lat = std::cos(home.lat_deg * kRadPerDeg);
  const double sin_lon = std::sin(home.lon_deg * kRadPerDeg);
  const double cos_lon = std::cos(home.lon_deg * kRadPerDeg);
  Eigen::Matrix3d R_NE;
  R_NE << -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,  //
      -sin_lon, cos_lon, 0.0,                               //
      -cos_lat * cos_lon, -cos_lat * sin_lon, -sin_lat;
  return R_NE;
}

}  // namespace

LocalProjection::LocalProjection(const Geodetic& home, EarthModel model)
    : home_(home), model_(model) {}

Geodetic LocalProjection::to_geodetic(const Eigen::Vector3d& p_N) const {
  if (model_ == EarthModel::kSphere) return sphere_to_geodetic(home_, p_N);
  if (p_N.isZero(0.0)) return home_;
  return from_ecef(to_ecef(home_) + rotation_NE(home_).transpose() * p_N);
}

Eigen::Vector3d LocalProjection::to_local(const Geodetic& place) const {
  if (model_ == EarthModel::kSphere) return sphere_to_local(home_, place);
  return rotation_NE(home_) * (to_ecef(place) - to_ecef(home_));
}

}  // namespace cas::base
