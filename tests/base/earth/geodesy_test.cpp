// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/geodesy.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cas::base {
namespace {

constexpr Geodetic kHome{47.397742, 8.545594, 488.0};
constexpr double kDegPerRad = 180.0 / M_PI;
constexpr double kSphereRadius = 6'371'000.0;

struct ProjectionCase {
  const char* name;
  Geodetic home;
  EarthModel model;
};

class Projection : public testing::TestWithParam<ProjectionCase> {};

TEST_P(Projection, RoundTripReturnsThePosition) {
  constexpr double kRounding = 1e-5;  // m: a latitude in degrees resolves about 1e-9 m; sums follow
  const LocalProjection projection(GetParam().home, GetParam().model);
  for (const double x : {-50'000.0, -120.0, 0.0, 0.01, 3.0, 20'000.0}) {
    for (const double y : {-20'000.0, -0.5, 0.0, 7.0, 900.0}) {
      const Eigen::Vector3d p_N(x, y, -35.0);
      EXPECT_TRUE((projection.to_local(projection.to_geodetic(p_N)) - p_N).isZero(kRounding))
          << p_N.transpose() << " came back as "
          << projection.to_local(projection.to_geodetic(p_N)).transpose();
    }
  }
}

TEST_P(Projection, ZeroDistanceIsTheHome) {
  const LocalProjection projection(GetParam().home, GetParam().model);
  const Geodetic place = projection.to_geodetic(Eigen::Vector3d::Zero());
  EXPECT_EQ(place.lat_deg, GetParam().home.lat_deg);
  EXPECT_EQ(place.lon_deg, GetParam().home.lon_deg);
  EXPECT_EQ(place.alt_m, GetParam().home.alt_m);
}

TEST_P(Projection, DownIsLessAltitude) {
  const LocalProjection projection(GetParam().home, GetParam().model);
  EXPECT_NEAR(projection.to_geodetic({0, 0, 2.5}).alt_m, GetParam().home.alt_m - 2.5, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Homes, Projection,
    testing::Values(ProjectionCase{"SphereZurich", kHome, EarthModel::kSphere},
                    ProjectionCase{"EllipsoidZurich", kHome, EarthModel::kWgs84},
                    ProjectionCase{"SphereSydney", {-33.8688, 151.2093, 58}, EarthModel::kSphere},
                    ProjectionCase{"EllipsoidSydney", {-33.8688, 151.2093, 58}, EarthModel::kWgs84},
                    ProjectionCase{"SphereFiji", {-17.7, 179.9999, 10}, EarthModel::kSphere},
                    ProjectionCase{"EllipsoidFiji", {-17.7, 179.9999, 10}, EarthModel::kWgs84},
                    ProjectionCase{"SphereEquator", {0, 0, 0}, EarthModel::kSphere},
                    ProjectionCase{"EllipsoidEquator", {0, 0, 0}, EarthModel::kWgs84},
                    ProjectionCase{"EllipsoidArctic", {88.0, 15.0, 0}, EarthModel::kWgs84}),
    [](const auto& test) { return test.param.name; });

TEST(SphereProjection, NorthIsLatitudeAlongTheMeridian) {
  const LocalProjection projection(kHome);
  const Geodetic place = projection.to_geodetic({1000, 0, 0});
  EXPECT_NEAR(place.lat_deg - kHome.lat_deg, 1000 / kSphereRadius * kDegPerRad, 1e-12);
  EXPECT_NEAR(place.lon_deg, kHome.lon_deg, 1e-12);
}

TEST(SphereProjection, EastOnTheEquatorIsLongitude) {
  const LocalProjection projection({0, 10, 0});
  const Geodetic place = projection.to_geodetic({0, 1000, 0});
  EXPECT_NEAR(place.lat_deg, 0.0, 1e-12);
  EXPECT_NEAR(place.lon_deg - 10, 1000 / kSphereRadius * kDegPerRad, 1e-12);
}

// Where arctan of the quotient, as [HILS] prints Eq. (5), lands on the wrong side of the globe.
TEST(SphereProjection, OverThePoleTheLongitudeIsOpposite) {
  const LocalProjection projection({89.0, 20.0, 0});
  const double two_degrees = 2.0 / kDegPerRad * kSphereRadius;
  const Geodetic place = projection.to_geodetic({two_degrees, 0, 0});
  EXPECT_NEAR(place.lat_deg, 89.0, 1e-9);
  EXPECT_NEAR(std::abs(place.lon_deg - 20.0), 180.0, 1e-9);
}

TEST(SphereProjection, CrossingTheDateLineWraps) {
  const Geodetic place = LocalProjection({0, 179.999, 0}).to_geodetic({0, 1000, 0});
  EXPECT_LT(place.lon_deg, -179.9);
}

TEST(EllipsoidProjection, OneDegreeOfLatitudeHasItsLengthOnTheEllipsoid) {
  // WGS 84 meridian radius of curvature a(1-e^2)/(1-e^2 sin^2)^1.5: at the equator 6 335 439 m, at
  // the pole 6 399 594 m; over 100 m the tangent plane and the arc agree.
  for (const auto& [lat_deg, radius_m] : {std::pair{0.0, 6'335'439.3}, {90.0, 6'399'593.6}}) {
    const double lat = std::min(lat_deg, 89.9995);
    const LocalProjection projection({lat, 0, 0}, EarthModel::kWgs84);
    const double d_lat = projection.to_geodetic({-100, 0, 0}).lat_deg - lat;
    EXPECT_NEAR(-d_lat / kDegPerRad * radius_m, 100.0, 1e-4);
  }
}

TEST(EllipsoidProjection, ThePlaneLeavesTheGroundByTheSquareOfTheDistance) {
  const LocalProjection projection({0, 0, 0}, EarthModel::kWgs84);
  const double rise_m = projection.to_geodetic({0, 1000, 0}).alt_m;
  EXPECT_NEAR(rise_m, 1000.0 * 1000.0 / (2 * 6'378'137.0), 1e-6);
}

TEST(EllipsoidProjection, DiffersFromTheSphereByTheKnownShareAtZurich) {
  const Eigen::Vector3d p_N(1000, 1000, 0);
  const Geodetic on_sphere = LocalProjection(kHome).to_geodetic(p_N);
  const Eigen::Vector3d back = LocalProjection(kHome, EarthModel::kWgs84).to_local(on_sphere);
  EXPECT_NEAR(back.x() / 1000.0, 1.0, 0.001);
  EXPECT_NEAR(back.y() / 1000.0, 1.003, 0.0005);
}

}  // namespace
}  // namespace cas::base
