// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/flat_ground.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace cas::sim {
namespace {

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

/// Squares of a metre from (-n, -n) to (n, n), two triangles each.
std::vector<Triangle> squares(int n) {
  std::vector<Triangle> triangles;
  for (int i = -n; i < n; ++i) {
    for (int j = -n; j < n; ++j) {
      const Eigen::Vector3d a(i, j, 0);
      const Eigen::Vector3d b(i + 1, j, 0);
      const Eigen::Vector3d c(i + 1, j + 1, 0);
      const Eigen::Vector3d d(i, j + 1, 0);
      triangles.push_back({a, b, c});
      triangles.push_back({c, a, d});  // wound the other way
    }
  }
  return triangles;
}

bool is_flat(const std::vector<Triangle>& triangles, double radius = 1.2,
             const Eigen::Vector3d& centre = {0.1, 0.2, 0.3}) {
  std::vector<TriangleSide> sides;
  return is_flat_within(triangles, kUp, centre, radius, sides);
}

TEST(FlatGround, IsFlatInAnyOrderOfItsTriangles) {
  std::vector<Triangle> triangles = squares(3);
  std::mt19937 random(1);
  for (int i = 0; i < 10; ++i) {
    std::shuffle(triangles.begin(), triangles.end(), random);
    EXPECT_TRUE(is_flat(triangles));
  }
}

TEST(FlatGround, EndsWhereItsTrianglesEnd) {
  EXPECT_TRUE(is_flat(squares(3), 2.5));
  EXPECT_FALSE(is_flat(squares(3), 3.0)) << "its edge is 2.8 m off";
  EXPECT_FALSE(is_flat({}));
}

TEST(FlatGround, HasNoHole) {
  std::vector<Triangle> triangles = squares(3);
  triangles.erase(triangles.begin() + 43);  // of the square around the middle
  EXPECT_FALSE(is_flat(triangles));
}

TEST(FlatGround, ASheetOfTwoSidesEndsLikeOneOfOne) {
  std::vector<Triangle> triangles = squares(3);
  const std::vector<Triangle> once = triangles;
  for (const Triangle& t : once) triangles.push_back({t[2], t[1], t[0]});
  EXPECT_TRUE(is_flat(triangles, 2.5));
  EXPECT_FALSE(is_flat(triangles, 3.0));
}

TEST(FlatGround, HasNoStepAndNoBend) {
  for (const double height : {1e-8, 1e-3}) {  // rounded away; a millimetre
    std::vector<Triangle> triangles = squares(3);
    for (Triangle& triangle : triangles) {
      for (Eigen::Vector3d& corner : triangle) {
        if (corner.x() == 1) corner.z() = height;
      }
    }
    EXPECT_EQ(is_flat(triangles), height < 1e-6) << height;
  }
}

}  // namespace
}  // namespace cas::sim
