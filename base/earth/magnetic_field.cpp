// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/magnetic_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/angles.hpp"
#include "base/earth/wgs84.hpp"
#include "base/earth/wmm2025.hpp"

namespace cas::base {
namespace {

using wgs84::kEccentricity2;
using wgs84::kSemiMajor_m;
using wmm2025::kDegree;

constexpr double kGaussPerNanotesla = 1e-5;
constexpr double kReferenceRadius = 6'371'200.0;  // m, geomagnetic reference sphere of the model
constexpr double kSmallestSine = 1e-9;  // keeps the east component's quotient finite at the poles

constexpr std::size_t kSize = kDegree + 1;
using Table = std::array<std::array<double, kSize>, kSize>;  // [degree][order]

/// Schmidt semi-normalised associated Legendre functions of cos(theta), and their derivatives.
struct Legendre {
  Table p{};
  Table dp{};  // d/dtheta
};

Legendre legendre(double cos_theta, double sin_theta) {
  Legendre l;
  l.p[0][0] = 1.0;
  for (std::size_t n = 1; n < kSize; ++n) {
    const auto nn = static_cast<double>(n);
    const double k = n == 1 ? 1.0 : std::sqrt((2.0 * nn - 1.0) / (2.0 * nn));
    l.p[n][n] = k * sin_theta * l.p[n - 1][n - 1];
    l.dp[n][n] = k * (sin_theta * l.dp[n - 1][n - 1] + cos_theta * l.p[n - 1][n - 1]);
    for (std::size_t m = 0; m < n; ++m) {
      const auto mm = static_cast<double>(m);
      const double a = 2.0 * nn - 1.0;
      const double b = std::sqrt(std::max(0.0, (nn - 1.0) * (nn - 1.0) - mm * mm));
      const double c = 1.0 / std::sqrt(nn * nn - mm * mm);
      const double p2 = m + 2 <= n ? l.p[n - 2][m] : 0.0;
      const double dp2 = m + 2 <= n ? l.dp[n - 2][m] : 0.0;
      l.p[n][m] = c * (a * cos_theta * l.p[n - 1][m] - b * p2);
      l.dp[n][m] = c * (a * (cos_theta * l.dp[n - 1][m] - sin_theta * l.p[n - 1][m]) - b * dp2);
    }
  }
  return l;
}

/// Geocentric latitude (rad) and distance from Earth's centre (m) of a place on WGS 84.
struct Geocentric {
  double lat = 0;
  double r = 0;
};

Geocentric to_geocentric(double lat, double height) {
  const double sin_lat = std::sin(lat);
  const double n = kSemiMajor_m / std::sqrt(1.0 - kEccentricity2 * sin_lat * sin_lat);
  const double p = (n + height) * std::cos(lat);
  const double z = (n * (1.0 - kEccentricity2) + height) * sin_lat;
  return {std::atan2(z, p), std::hypot(p, z)};
}

/// Negative gradient of the potential in geocentric north, east, down, nT. WMM2025 technical
/// report, Eq. (10)-(12).
Eigen::Vector3d field_on_sphere(const Geocentric& place, double lon, double years) {
  const double cos_theta = std::sin(place.lat);
  const double sin_theta = std::max(std::cos(place.lat), kSmallestSine);
  const Legendre l = legendre(cos_theta, sin_theta);
  const double ratio = kReferenceRadius / place.r;
  std::array<double, kSize> power;  // (a/r)^(n+2)
  power[0] = ratio * ratio;
  for (std::size_t n = 1; n < kSize; ++n) power[n] = power[n - 1] * ratio;
  Eigen::Vector3d field = Eigen::Vector3d::Zero();
  for (const wmm2025::Term& term : wmm2025::kTerms) {
    const auto n = static_cast<std::size_t>(term.n);
    const auto m = static_cast<std::size_t>(term.m);
    const double g = term.g_nt + years * term.g_nt_per_year;
    const double h = term.h_nt + years * term.h_nt_per_year;
    const double cos_m = std::cos(term.m * lon);
    const double sin_m = std::sin(term.m * lon);
    const double along = g * cos_m + h * sin_m;
    field.x() += power[n] * along * l.dp[n][m];
    field.y() += power[n] * term.m * (g * sin_m - h * cos_m) * l.p[n][m] / sin_theta;
    field.z() -= power[n] * (term.n + 1) * along * l.p[n][m];
  }
  return field;
}

}  // namespace

Eigen::Vector3d magnetic_field_N(const Geodetic& place, double decimal_year) {
  const double years =
      std::clamp(decimal_year, wmm2025::kEpochYear, wmm2025::kLastYear) - wmm2025::kEpochYear;
  const double lat = place.lat_deg * kRadPerDeg;
  const Geocentric geocentric = to_geocentric(lat, place.alt_m);
  const Eigen::Vector3d field =
      field_on_sphere(geocentric, place.lon_deg * kRadPerDeg, years) * kGaussPerNanotesla;
  // from the sphere's vertical to the ellipsoid's
  const double psi = geocentric.lat - lat;
  return {field.x() * std::cos(psi) - field.z() * std::sin(psi), field.y(),
          field.x() * std::sin(psi) + field.z() * std::cos(psi)};
}

double magnetic_declination(const Geodetic& place, double decimal_year) {
  const Eigen::Vector3d b_N = magnetic_field_N(place, decimal_year);
  return std::atan2(b_N.y(), b_N.x());
}

}  // namespace cas::base
