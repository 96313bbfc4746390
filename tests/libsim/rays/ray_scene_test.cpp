// SPDX-License-Identifier: BSD-3-Clause
// Rays by Embree against closed form and against those of ODE, which feel for the same shapes.
#include "libsim/core/rays/ray_scene.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "base/random.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/libsim/support/triangles.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;

constexpr double kRange_m = 100;

Shape placed(const Geometry& geometry, const Vector3d& at,
             const Eigen::Vector3d& turn = {0, 0, 0}) {
  Shape shape = test::standing("shape", geometry, at);
  if (turn.norm() > 0) shape.pose.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return shape;
}

std::shared_ptr<TriangleMesh> hills() {
  const WorldModel ground = test::ground_of_triangles(
      0.1, 1.0, [](double x, double y) { return 0.3 * std::sin(2 * x) * std::cos(1.7 * y); });
  auto mesh =
      std::make_shared<TriangleMesh>(*std::get<Mesh>(ground.statics.at(0).geometry).triangles);
  for (Vector3d& vertex : mesh->vertices) vertex *= 10;  // 60 m by 60 m
  return mesh;
}

std::shared_ptr<TriangleMesh> tetrahedron() {
  return std::make_shared<TriangleMesh>(
      TriangleMesh{.vertices = {{0, 0, 1}, {1, 0, -0.5}, {-0.5, 0.9, -0.5}, {-0.5, -0.9, -0.5}},
                   .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}});
}

/// Every kind of shape, at rest and in motion.
WorldModel many_shapes() {
  base::NormalRandom random(7);
  const auto between = [&](double low, double high) {
    return low + random.uniform() * (high - low);
  };
  const auto turn = [&] { return Vector3d(random(), random(), random()); };
  WorldModel model;
  model.gravity_W = {0, 0, -test::kGravity};
  model.statics.push_back(placed(Plane{}, {0, 0, -1.5}, {0.02, -0.01, 0}));
  model.statics.push_back(placed(Mesh{hills()}, {1, -2, 0}, {0, 0, 0.3}));
  for (int i = 0; i < 30; ++i) {
    const Vector3d at(between(-25, 25), between(-25, 25), between(0, 12));
    const Vector3d size(between(0.5, 4), between(0.5, 4), between(0.5, 4));
    model.statics.push_back(placed(Box{size}, at, turn()));
    model.statics.push_back(placed(Sphere{size.x() / 2}, at + 5 * Vector3d::UnitX(), turn()));
    model.statics.push_back(
        placed(Cylinder{size.x() / 2, size.y()}, at - 5 * Vector3d::UnitY(), turn()));
    model.statics.push_back(placed(Mesh{tetrahedron()}, at + 4 * Vector3d::UnitY(), turn()));
  }
  Eigen::Isometry3d from = Eigen::Isometry3d::Identity();
  from.translation() = Vector3d(-8, 3, 6);
  Eigen::Isometry3d to = from;
  to.translation() = Vector3d(8, -3, 6);
  to.rotate(Eigen::AngleAxisd(2, Vector3d(1, 2, 3).normalized()));
  model.moving.push_back(
      {.name = "car",
       .shapes = {placed(Box{{3, 2, 2}}, {0, 0, 0}), placed(Sphere{1}, {2, 0, 0.5})},
       .path = ObstaclePath({{0, from}, {1, to}}, true, 0)});
  return model;
}

std::unique_ptr<SimWorld> start(const WorldModel& model, bool by_embree) {
  auto world = test::make_world(model);
  world->add_vehicle(test::crate(), {.z_m = 15});
  world->add_vehicle(test::crate({2, 2, 1}), {.x_m = 5, .z_m = 16});
  if (by_embree) world->expect_rays();
  world->start();
  for (int i = 0; i < 400; ++i) world->advance(test::kStep_s);
  return world;
}

bool has_embree() {
  return make_ray_scene(std::vector<Shape>{placed(Sphere{1}, {0, 0, 0})}) != nullptr;
}

TEST(RayScene, FindsWhatOdeFinds) {
  if (!has_embree()) GTEST_SKIP() << "built without Embree";
  constexpr std::size_t kRays = 100'000;
  constexpr double kSame_m = 1e-3;
  const WorldModel model = many_shapes();
  const auto ode = start(model, false);
  const auto embree = start(model, true);
  base::NormalRandom random(3);
  std::vector<Vector3d> origins;
  std::vector<Vector3d> directions;
  for (std::size_t i = 0; i < kRays; ++i) {
    const Vector3d unit(random.uniform(), random.uniform(), random.uniform());
    origins.push_back(unit.cwiseProduct(Vector3d(60, 60, 20)) - Vector3d(30, 30, 4));
    directions.emplace_back(random(), random(), random());
  }
  std::vector<RayHit> by_ode(kRays);
  std::vector<RayHit> by_embree(kRays);
  ode->cast(VehicleId{0}, origins, directions, kRange_m, by_ode);
  embree->cast(VehicleId{0}, origins, directions, kRange_m, by_embree);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < kRays; ++i) {
    const double a = by_ode[i].distance_m;
    const double b = by_embree[i].distance_m;
    hits += std::isfinite(a) ? 1U : 0U;
    if (std::isinf(a) && std::isinf(b)) continue;
    EXPECT_NEAR(a, b, kSame_m) << "ray " << i << " from " << origins[i].transpose() << " along "
                               << directions[i].normalized().transpose();
    ASSERT_LE(by_embree[i].normal.dot(directions[i]), 0) << "ray " << i;
    ASSERT_NEAR(by_embree[i].normal.norm(), 1, 1e-9) << "ray " << i;
  }
  EXPECT_GT(hits, kRays / 2);
  EXPECT_LT(hits, kRays);
}

struct RayCase {
  const char* name;
  Geometry geometry;
  Vector3d origin;
  Vector3d direction;
  double distance_m;  // infinite: none
  Vector3d normal;
};

class RayOnShape : public testing::TestWithParam<RayCase> {};

TEST_P(RayOnShape, IsExact) {
  if (!has_embree()) GTEST_SKIP() << "built without Embree";
  constexpr double kRounding_m = 1e-9;
  const auto& [name, geometry, origin, direction, distance_m, normal] = GetParam();
  // Far from the origin, where single precision is good for 0.06 mm.
  const Vector3d at(1000.1, -500.7, 30.3);
  const auto scene = make_ray_scene(std::vector<Shape>{placed(geometry, at)});
  const auto hit = scene->cast(at + origin, direction.normalized(), kRange_m);
  ASSERT_EQ(hit.has_value(), std::isfinite(distance_m));
  if (!hit) return;
  EXPECT_NEAR(hit->distance_m, distance_m, kRounding_m);
  EXPECT_TRUE(hit->normal.isApprox(normal, 1e-9)) << hit->normal.transpose();
}

const double kNone = std::numeric_limits<double>::infinity();
INSTANTIATE_TEST_SUITE_P(
    Shapes, RayOnShape,
    testing::Values(
        RayCase{"PlaneFromAbove", Plane{}, {0, 0, 3}, {0, 3, -4}, 3.75, {0, 0, 1}},
        RayCase{"PlaneFromBelow", Plane{}, {0, 0, -3}, {0, 0, 1}, 3, {0, 0, -1}},
        RayCase{"PlaneBehind", Plane{}, {0, 0, 3}, {0, 1, 0.1}, kNone, {}},
        RayCase{"PlaneBeyondTheRange", Plane{}, {0, 0, 100.001}, {0, 0, -1}, kNone, {}},
        RayCase{"BoxFromOutside", Box{{2, 4, 6}}, {5, 1, 2}, {-1, 0, 0}, 4, {1, 0, 0}},
        RayCase{"BoxFromInside", Box{{2, 4, 6}}, {0.5, 1, 2}, {-1, 0, 0}, 1.5, {1, 0, 0}},
        RayCase{"BoxMissed", Box{{2, 4, 6}}, {5, 2.001, 2}, {-1, 0, 0}, kNone, {}},
        RayCase{"SphereFromOutside", Sphere{2}, {0, -7, 0}, {0, 1, 0}, 5, {0, -1, 0}},
        RayCase{"SphereFromInside", Sphere{2}, {0, 0, 1}, {0, 0, 1}, 1, {0, 0, -1}},
        RayCase{"CylinderRound", Cylinder{1, 4}, {3, 0, 1}, {-1, 0, 0}, 2, {1, 0, 0}},
        RayCase{"CylinderCap", Cylinder{1, 4}, {0.5, 0.5, 7}, {0, 0, -1}, 5, {0, 0, 1}},
        RayCase{"CylinderOverItsCap", Cylinder{1, 4}, {3, 0, 2.001}, {-1, 0, 0}, kNone, {}},
        RayCase{"Triangles", Mesh{tetrahedron()}, {0.1, 0.1, -3}, {0, 0, 1}, 2.5, {0, 0, -1}},
        RayCase{
            "TrianglesFromInside", Mesh{tetrahedron()}, {0, 0.1, 0}, {0, 0, -1}, 0.5, {0, 0, 1}}),
    [](const auto& test) { return test.param.name; });

/// A scene costs memory and time, which a world without such sensors does not spend.
TEST(RayScene, IsMadeOnlyWhereItIsExpected) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // in a process of its own
  const auto is_loaded = [](bool expected) {
    const auto world = start(test::flat_world(), expected);
    std::exit(dlopen(CAS_RAYS_FILE, RTLD_NOLOAD | RTLD_LAZY) != nullptr ? 1 : 0);
  };
  EXPECT_EXIT(is_loaded(false), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(is_loaded(true), testing::ExitedWithCode(CAS_HAS_RAYS), "");
}

}  // namespace
}  // namespace cas::sim
