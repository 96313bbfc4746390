// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/contact_patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "libsim/core/ode/contact_law.hpp"

namespace cas::sim {
namespace {

std::vector<KeptContact> kept_of(const std::vector<ContactPoint>& points) {
  std::vector<KeptContact> kept;
  keep_outermost(points, kept);
  return kept;
}

std::set<std::size_t> indices(const std::vector<KeptContact>& kept) {
  std::set<std::size_t> out;
  for (const KeptContact& k : kept) out.insert(k.index);
  return out;
}

ContactPoint at(double x, double y, double depth = 1e-3) {
  return {.p_W = {x, y, 0}, .n_W = Eigen::Vector3d::UnitZ(), .depth_m = depth, .kind = 0};
}

/// Corners of a square first, then points within it.
std::vector<ContactPoint> square_full_of_points() {
  std::vector<ContactPoint> points{at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> inside(-0.9, 0.9);
  for (int i = 0; i < 62; ++i) points.push_back(at(inside(random), inside(random)));
  return points;
}

TEST(ContactPatch, KeepsTheCornersOfASquareFullOfPoints) {
  EXPECT_EQ(indices(kept_of(square_full_of_points())), (std::set<std::size_t>{0, 1, 2, 3}));
}

TEST(ContactPatch, DoesNotDependOnTheOrderOfThePoints) {
  std::vector<ContactPoint> points = square_full_of_points();
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    std::shuffle(points.begin(), points.end(), random);
    for (const KeptContact& k : kept_of(points)) {
      EXPECT_EQ(points[k.index].p_W.cwiseAbs(), Eigen::Vector3d(1, 1, 0));
    }
    EXPECT_EQ(kept_of(points).size(), 4u);
  }
}

TEST(ContactPatch, DepthsThatRoundingMakesDifferDoNotChangeTheChoice) {
  std::vector<ContactPoint> points = square_full_of_points();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
  for (ContactPoint& point : points) point.depth_m += noise(random);
  EXPECT_EQ(indices(kept_of(points)), (std::set<std::size_t>{0, 1, 2, 3}));
}

TEST(ContactPatch, KeepsTheDeepestToo) {
  std::vector<ContactPoint> points = square_full_of_points();
  points[10].depth_m = 5e-3;
  const auto kept = kept_of(points);
  EXPECT_EQ(indices(kept), (std::set<std::size_t>{0, 1, 2, 3, 10}));
  for (const KeptContact& k : kept) EXPECT_EQ(k.patch, 0u);
}

TEST(ContactPatch, PointsAtOnePlaceCountOnceAndTheDeepestOfThemIsTaken) {
  EXPECT_EQ(indices(kept_of({at(0, 0, 1e-3), at(0, 0, 1.05e-3), at(0, 0, 0.9e-3)})),
            (std::set<std::size_t>{1}));
}

TEST(ContactPatch, ALineKeepsItsEnds) {
  EXPECT_EQ(indices(kept_of({at(0.1, 0), at(0, 0), at(0.7, 0), at(1, 0), at(0.4, 0)})),
            (std::set<std::size_t>{1, 3}));
}

TEST(ContactPatch, FloorAndWallAreTwoPatches) {
  std::vector<ContactPoint> points = square_full_of_points();
  for (const double z : {0.0, 0.1}) {
    points.push_back({.p_W = {1, 0, z}, .n_W = {-1, 0, 0}, .depth_m = 2e-3, .kind = 0});
  }
  const auto kept = kept_of(points);
  ASSERT_EQ(kept.size(), 6u);
  EXPECT_EQ(kept.front().patch, 0u) << "the deepest patch is the first";
  EXPECT_EQ(points[kept.front().index].n_W.x(), -1.0);
  EXPECT_EQ(kept.back().patch, 1u);
}

TEST(ContactPatch, SurfacesOfDifferentKindsAreNotMixed) {
  std::vector<ContactPoint> points{at(-1, 0), at(1, 0), at(0, 0.2)};
  points.back().kind = 1;
  const auto kept = kept_of(points);
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_NE(kept.front().patch, kept.back().patch);
}

TEST(ContactPatch, RoughGroundHasABound) {
  std::vector<ContactPoint> points;
  for (int i = 0; i < 400; ++i) {
    const double a = 0.3 * i;
    points.push_back({.p_W = {std::cos(a), std::sin(a), 0.01 * i},
                      .n_W = Eigen::Vector3d(std::cos(a), std::sin(a), 0.2).normalized(),
                      .depth_m = 1e-3,
                      .kind = 0});
  }
  EXPECT_LE(kept_of(points).size(), kMostContacts);
  EXPECT_GE(kept_of(points).size(), 8u);
  EXPECT_TRUE(kept_of({}).empty());
}

TEST(ContactLaw, APatchIsAsStiffWithFourContactsAsWithOne) {
  const ContactSpring one = default_spring(1.5, 1e-3, 1e-3, 1);
  const ContactSpring quarter = default_spring(1.5, 1e-3, 4e-3, 4);
  EXPECT_NEAR(one.stiffness, 4 * quarter.stiffness, 1e-9 * one.stiffness);
  EXPECT_NEAR(one.damping, 4 * quarter.damping, 1e-9 * one.damping);
}

TEST(ContactLaw, TheSpringOfAContactBeginsWithoutAJump) {
  const ContactSpring grazing = default_spring(1.5, 1e-9, 4e-3, 4);
  EXPECT_LT(grazing.force(1e-9, 0.0), 1e-6);
}

TEST(ContactPatch, TheNextTriangleOfASurfaceIsNoEdge) {
  std::vector<ContactPoint> points = square_full_of_points();
  for (ContactPoint& point : points)
    point.face_W = -Eigen::Vector3d::UnitZ();  // wound the other way
  ContactPoint sliver = at(1, 0, 1e-4);
  sliver.n_W = {-1, 0, 0};
  sliver.face_W = Eigen::Vector3d(0.1, 0, 1).normalized();
  points.insert(points.begin(), sliver);
  ContactPoint wall = at(1, 0.5, 1e-4);
  wall.n_W = {-1, 0, 0};
  wall.face_W = {-1, 0, 0};
  points.push_back(wall);
  const std::size_t before = points.size();
  drop_inner_edges(points);
  EXPECT_EQ(points.size(), before - 1);
  EXPECT_TRUE(std::none_of(points.begin(), points.end(), [&](const ContactPoint& point) {
    return point.face_W == sliver.face_W;
  })) << "the wall stays";
}

TEST(ContactPatch, AnEdgeThatIsMetAloneStays) {
  ContactPoint edge = at(1, 0, 1e-4);
  edge.n_W = {-1, 0, 0};
  edge.face_W = {0, 0, 1};
  std::vector<ContactPoint> points{edge, edge};
  drop_inner_edges(points);
  EXPECT_EQ(points.size(), 2u);
}

TEST(ContactLaw, StiffnessesOfTheFileAreInSeriesAndDampingsAdd) {
  const Surface ground{.friction = 1, .stiffness_n_m = 3e4, .damping_n_s_m = 20.0};
  const Surface skid{.friction = 1, .stiffness_n_m = 6e4, .damping_n_s_m = 5.0};
  const Surface plain;
  EXPECT_FALSE(has_own_spring(plain, plain));
  EXPECT_TRUE(has_own_spring(plain, ground));
  EXPECT_NEAR(own_spring(ground, skid).stiffness, 2e4, 1e-6);
  EXPECT_NEAR(own_spring(ground, skid).damping, 25, 1e-9);
  EXPECT_NEAR(own_spring(ground, plain).stiffness, 3e4, 1e-2);
  EXPECT_NEAR(own_spring(ground, plain).damping, 20, 1e-9);
  const Surface stiff{.friction = 1, .stiffness_n_m = 1e6};
  EXPECT_NEAR(own_spring(stiff, plain).damping, 1.0, 1e-9) << "the default of SDF";
}

TEST(ContactLaw, WhatSlipsFindsNothingAcrossIt) {
  EXPECT_EQ(hold_across(0.0, 0.01), 1.0);
  EXPECT_EQ(hold_across(0.01, 0.01), 1.0);
  EXPECT_EQ(hold_across(0.02, 0.01), 0.0);
  EXPECT_EQ(hold_across(1.0, 0.0), 0.0);
}

}  // namespace
}  // namespace cas::sim
