// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/magnetic_field.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cas::base {
namespace {

constexpr double kDegPerRad = 180.0 / M_PI;
constexpr double kDate = 2026.0 + 229.0 / 365.0;  // 2026-08-18, day 230 of the year
// Reference and model agree in all terms; the rest is the rounding of the date (0.1 degrees a year
// over a day) and of the ellipsoid's axes.
constexpr double kDeclinationToleranceDeg = 5e-4;

TEST(Declination, MatchesAnIndependentEvaluation) {
  struct DeclinationCase {
    const char* name;
    Geodetic place;
    double declination_deg;
  };
  const DeclinationCase rows[] = {{"London", {51.5074, -0.1278, 11.0}, 1.183814668460281},
                                  {"Sydney", {-33.8688, 151.2093, 58.0}, 12.823416712834861},
                                  {"Anchorage", {61.2181, -149.9003, 31.0}, 14.02575876261327},
                                  {"Quito", {-0.1807, -78.4678, 2850.0}, -5.067784309993424},
                                  {"Tangier", {35.7595, -5.834, 10.0}, 0.05031443483867547},
                                  {"Nouakchott", {18.0858, -15.9785, 5.0}, -4.595488718661336}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_NEAR(magnetic_declination(row.place, kDate) * kDegPerRad, row.declination_deg,
                kDeclinationToleranceDeg);
  }
}

TEST(MagneticField, ZurichHasTheFieldThatFlightControllersExpect) {
  const Eigen::Vector3d b_N = magnetic_field_N({47.397742, 8.545594, 488.0}, 2025.0);
  constexpr double kTable = 0.01;  // gauss; a ten-degree table is no better
  EXPECT_NEAR(b_N.x(), 0.215, kTable);
  EXPECT_NEAR(b_N.y(), 0.0125, kTable);
  EXPECT_NEAR(b_N.z(), 0.427, kTable);
}

/// Field in W axes fixed at `origin`, so that differences between neighbours are derivatives.
Eigen::Vector3d field_at(const LocalProjection& projection, const Eigen::Vector3d& p_N) {
  const Geodetic place = projection.to_geodetic(p_N);
  const Eigen::Vector3d b = magnetic_field_N(place, 2027.0);
  // Columns: north, east, down of `place` seen from the origin, by small steps.
  constexpr double kStep = 10.0;
  const LocalProjection there(place, EarthModel::kWgs84);
  Eigen::Matrix3d R_N0N;
  for (int axis = 0; axis < 3; ++axis) {
    const Geodetic moved = there.to_geodetic(kStep * Eigen::Vector3d::Unit(axis));
    R_N0N.col(axis) = (projection.to_local(moved) - p_N) / kStep;
  }
  return R_N0N * b;
}

// A potential field in free space: no divergence and no curl, whatever the coefficients.
TEST(MagneticField, IsFreeOfDivergenceAndCurl) {
  constexpr double kStep = 20'000.0;  // m
  constexpr double kResidue = 2e-4;   // of the gradient's own size; the third derivative's part
  for (const Geodetic& home :
       {Geodetic{47.4, 8.5, 488}, Geodetic{-60, 120, 0}, Geodetic{5, -70, 3000}}) {
    const LocalProjection projection(home, EarthModel::kWgs84);
    Eigen::Matrix3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
      gradient.col(axis) = (field_at(projection, step) - field_at(projection, -step)) / (2 * kStep);
    }
    EXPECT_NEAR(gradient.trace() / gradient.norm(), 0.0, kResidue);
    EXPECT_NEAR((gradient - gradient.transpose()).norm() / gradient.norm(), 0.0, kResidue);
  }
}

TEST(MagneticField, IsFiniteAndContinuousAtThePoles) {
  for (const double pole : {90.0, -90.0}) {
    const Eigen::Vector3d at = magnetic_field_N({pole, 30, 0}, 2025.0);
    const Eigen::Vector3d near = magnetic_field_N({pole * (1 - 1e-8), 30, 0}, 2025.0);
    EXPECT_TRUE(at.allFinite());
    EXPECT_LT((at - near).norm(), 1e-6);
  }
}

TEST(MagneticField, PointsDownInTheNorthAndUpInTheSouth) {
  EXPECT_GT(magnetic_field_N({80, 0, 0}, 2025).z(), 0.5);
  EXPECT_LT(magnetic_field_N({-80, 0, 0}, 2025).z(), -0.4);
}

TEST(MagneticField, ChangesWithTheYearAndStopsAtTheModelsEnds) {
  const Geodetic place{51.5, 0, 0};
  EXPECT_NE(magnetic_declination(place, 2025), magnetic_declination(place, 2029));
  EXPECT_EQ(magnetic_declination(place, 2020), magnetic_declination(place, 2025));
  EXPECT_EQ(magnetic_declination(place, 2040), magnetic_declination(place, 2030));
}

TEST(MagneticField, WeakensWithAltitude) {
  const double low = magnetic_field_N({47, 8, 0}, 2025).norm();
  const double high = magnetic_field_N({47, 8, 100'000}, 2025).norm();
  EXPECT_NEAR(high / low, std::pow(6371.2 / 6471.2, 3), 0.01);  // chiefly a dipole
}

}  // namespace
}  // namespace cas::base
