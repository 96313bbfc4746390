// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/remembered_points.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cas::sim {
namespace {

using Eigen::Vector3d;

const Vector3d kLeaning = Vector3d(0.3, 0, 1).normalized();

ContactPoint on_triangle(const Vector3d& p_W, const Vector3d& face_W = Vector3d::UnitZ(),
                         double depth_m = 1e-3) {
  return {.p_W = p_W, .n_W = face_W, .depth_m = depth_m, .kind = 0, .face_W = face_W};
}

BodyMove moved(const Vector3d& way_W) {
  return {.from_W = Vector3d::Zero(), .to_W = way_W, .turn = Eigen::Quaterniond::Identity()};
}
const BodyMove kStill = moved(Vector3d::Zero());

/// Result of a second search after a move, when the first search had found `before`.
/// @param points  found by the second search
std::vector<ContactPoint> after(const BodyMove& move, std::vector<ContactPoint> points,
                                const ContactPoint& before = on_triangle({0.1, 0, 0})) {
  RememberedPoints remembered;
  std::vector<ContactPoint> first{before};
  remembered.add_to(first, kStill);
  EXPECT_EQ(first.size(), 1u) << "nothing is remembered at first";
  remembered.add_to(points, move);
  return points;
}

TEST(RememberedPoints, AreAddedWhereASearchMissesThem) {
  const auto points = after(kStill, {on_triangle({-0.1, 0, 0}, kLeaning)});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].p_W, Vector3d(0.1, 0, 0));
}

TEST(RememberedPoints, AreNotAddedBesideThemselves) {
  EXPECT_EQ(after(kStill, {on_triangle({0.101, 0, 0})}).size(), 1u);
  EXPECT_EQ(after(kStill, {on_triangle({0.101, 0, 0}, kLeaning)}).size(), 2u)
      << "of a face that leans another way";
  ContactPoint other = on_triangle({0.101, 0, 0});
  other.kind = 1;
  EXPECT_EQ(after(kStill, {other}).size(), 2u) << "of another surface";
}

TEST(RememberedPoints, MoveWithTheBodyAndAreAsDeepAsItIs) {
  const auto points = after(moved({1e-3, 0, 4e-4}), {});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_TRUE(points[0].p_W.isApprox(Vector3d(0.101, 0, 4e-4)));
  EXPECT_NEAR(points[0].depth_m, 6e-4, 1e-12);
}

TEST(RememberedPoints, TurnAboutTheCentreOfGravity) {
  BodyMove move = kStill;
  move.turn = Eigen::AngleAxisd(0.01, Vector3d::UnitZ());
  const auto points = after(move, {});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].p_W.y(), 0.1 * std::sin(0.01), 1e-9);
}

TEST(RememberedPoints, EndWhenTheyLeaveTheGroundOrSlide) {
  EXPECT_TRUE(after(moved({0, 0, 1.1e-3}), {}).empty()) << "lifted";
  EXPECT_TRUE(after(moved({5.1e-3, 0, 0}), {}).empty()) << "slid by 5 mm";
  EXPECT_EQ(after(moved({4.9e-3, 0, 0}), {}).size(), 1u);
}

TEST(RememberedPoints, SlideAddsUpOverSearches) {
  RememberedPoints remembered;
  std::vector<ContactPoint> points{on_triangle({0.1, 0, 0})};
  remembered.add_to(points, kStill);
  for (int i = 0; i < 5; ++i) {
    points.clear();
    remembered.add_to(points, moved({i % 2 == 0 ? 1.1e-3 : -1.1e-3, 0, 0}));
  }
  EXPECT_TRUE(points.empty()) << "back and forth, 5.5 mm in all";
}

TEST(RememberedPoints, AreOfTrianglesAlone) {
  ContactPoint on_plane = on_triangle({0.1, 0, 0});
  on_plane.face_W.setZero();
  EXPECT_TRUE(after(kStill, {}, on_plane).empty());
}

TEST(RememberedPoints, AreNoMoreThanTheirRoomAndCanBeForgotten) {
  RememberedPoints remembered;
  std::vector<ContactPoint> points;
  for (int i = 0; i < 100; ++i) points.push_back(on_triangle({0.01 * i, 0, 0}));
  remembered.add_to(points, kStill);
  EXPECT_EQ(remembered.size(), RememberedPoints::kMost);
  remembered.forget();
  points.clear();
  remembered.add_to(points, kStill);
  EXPECT_TRUE(points.empty());
}

}  // namespace
}  // namespace cas::sim
