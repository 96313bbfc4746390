// SPDX-License-Identifier: BSD-3-Clause
// Moving obstacles: their paths and their contacts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libsim/core/body/obstacle_path.hpp"
#include "libsim/core/load/world_loader.hpp"
#include "libsim/core/run/beacons.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

Eigen::Isometry3d pose(const Vector3d& p, double yaw = 0) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = p;
  X.linear() = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix();
  return X;
}

/// 4 m east in 2 s, then 2 m north in 2 s while it turns to the left.
ObstaclePath way(bool loop, double delay_s = 0) {
  return ObstaclePath({{0, pose({0, 0, 1})}, {2, pose({4, 0, 1})}, {4, pose({4, 2, 1}, M_PI / 2)}},
                      loop, delay_s);
}

TEST(ObstaclePath, GoesStraightAndEvenlyFromPlaceToPlace) {
  const BodyState first = way(false).at(0.5);
  EXPECT_TRUE(first.p_WB.isApprox(Vector3d(1, 0, 1), 1e-12));
  EXPECT_TRUE(first.v_WB.isApprox(Vector3d(2, 0, 0), 1e-12));
  EXPECT_LT(first.w_WB_B.norm(), 1e-12);
  const BodyState second = way(false).at(3);
  EXPECT_TRUE(second.p_WB.isApprox(Vector3d(4, 1, 1), 1e-12));
  EXPECT_TRUE(second.v_WB.isApprox(Vector3d(0, 1, 0), 1e-12));
  EXPECT_TRUE(second.w_WB_B.isApprox(Vector3d(0, 0, M_PI / 4), 1e-9));
  EXPECT_TRUE((second.q_WB * Vector3d::UnitX())
                  .isApprox(Vector3d(std::sqrt(0.5), std::sqrt(0.5), 0), 1e-9));
}

TEST(ObstaclePath, StaysAtItsEndOrBeginsAgain) {
  EXPECT_TRUE(way(false).at(99).p_WB.isApprox(Vector3d(4, 2, 1), 1e-12));
  EXPECT_EQ(way(false).at(99).v_WB.norm(), 0);
  EXPECT_TRUE(way(true).at(8.5).p_WB.isApprox(Vector3d(1, 0, 1), 1e-12));
}

TEST(ObstaclePath, WaitsForItsDelay) {
  EXPECT_EQ(way(true, 3).at(2.9).v_WB.norm(), 0);
  EXPECT_TRUE(way(true, 3).at(3.5).p_WB.isApprox(Vector3d(1, 0, 1), 1e-12));
}

/// A slab of 4 x 4 x 0.2 m whose top is at 1 m, east at 1 m/s for 10 s.
WorldModel slab_world() {
  WorldModel model = test::flat_world();
  model.moving.push_back(
      {"slab",
       {test::standing("slab/top", Box{{4, 4, 0.2}})},
       ObstaclePath({{0, pose({0, 0, 0.9})}, {10, pose({10, 0, 0.9})}}, false, 0)});
  return model;
}

TEST(MovingObstacle, CarriesWhatStandsOnIt) {
  const auto world = test::make_world(slab_world());
  const VehicleId id = world->add_vehicle(test::crate(), {.z_m = 1.0});
  world->start();
  for (int i = 0; i < 3000; ++i) world->advance(1e-3);
  const BodyState& state = world->state(id);
  EXPECT_NEAR(state.v_WB.x(), 1, 1e-3);
  // Friction 1 brings it to 1 m/s in 0.1 s, in which it falls 5 cm behind.
  EXPECT_NEAR(state.p_WB.x(), 3, 0.1);
  EXPECT_NEAR(state.p_WB.z(), 1.05, 5e-3);
  EXPECT_TRUE(world->in_contact(id));
}

BeaconConfig pad_with(const std::string& keys) {
  const auto node = base::ConfigNode::parse("{" + keys + "}", "world.yaml");
  BeaconConfig pad;
  pad.node = node;
  pad.name = "pad";
  pad.x_m = 1;
  pad.y_m = 0.5;
  if (const auto on = node.find("on")) pad.on = on->as<std::string>();
  if (const auto z = node.find("z_m")) pad.z_m = z->as<double>();
  return pad;
}

TEST(Beacon, GoesWithItsObstacle) {
  const WorldModel model = slab_world();
  const auto world = test::make_world(model);
  const BeaconSource source = beacon_source(pad_with("on: slab, z_m: 0.1"), model, *world);
  EXPECT_TRUE(
      source.place_W(base::SimTime(std::chrono::seconds(4))).isApprox(Vector3d(5, 0.5, 1), 1e-12));
}

TEST(Beacon, StandsOnTheUppermostSurfaceThatNeverMoves) {
  WorldModel model = slab_world();
  model.statics.push_back(test::standing("table", Box{{2, 2, 0.7}}, {1, 0, 0.35}));
  const auto world = test::make_world(model);
  const BeaconSource source = beacon_source(pad_with(""), model, *world);
  EXPECT_TRUE(source.place_W({}).isApprox(Vector3d(1, 0.5, 0.7), 1e-9));
  EXPECT_EQ(beacon_source(pad_with("z_m: 0.2"), model, *world).place_W({}).z(), 0.2);
}

TEST(Beacon, RefusesAnObstacleThatIsNotThere) {
  const WorldModel model = slab_world();
  const auto world = test::make_world(model);
  EXPECT_THAT(
      cas::test::refusal([&] { beacon_source(pad_with("on: slap, z_m: 0"), model, *world); }),
      HasSubstr("world.yaml:1: on: the world has no moving obstacle 'slap'; did you mean 'slab'?"));
  const auto nothing = test::make_world(WorldModel{});
  EXPECT_THAT(cas::test::refusal([&] { beacon_source(pad_with(""), WorldModel{}, *nothing); }),
              HasSubstr("needs z_m"));
}

TEST(MovingObstacle, PushesWhatRestsInItsWay) {
  WorldModel model = test::flat_world();
  model.moving.push_back(
      {"car",
       {test::standing("car/body", Box{{1, 2, 1}})},
       ObstaclePath({{0, pose({-3, 0, 0.55})}, {4, pose({3, 0, 0.55})}}, false, 0)});
  const auto world = test::make_world(model);
  const VehicleId id = world->add_vehicle(test::crate(), {});
  world->start();
  for (int i = 0; i < 1000; ++i) world->advance(1e-3);
  EXPECT_NEAR(world->state(id).p_WB.x(), 0, 1e-9) << "the car is not there yet";
  for (int i = 0; i < 4000; ++i) world->advance(1e-3);
  // The car's front ends at 3.5 m, and half of the crate is before it.
  EXPECT_GT(world->state(id).p_WB.x(), 3.5 + 0.15);
  const Vector3d first = world->state(id).p_WB;
  world->reset();
  for (int i = 0; i < 5000; ++i) world->advance(1e-3);
  EXPECT_EQ(world->state(id).p_WB, first) << "the same way again";
}

TEST(MovingObstacle, IsSeenByRays) {
  const auto world = test::make_world(slab_world());
  const VehicleId id = world->add_vehicle(test::crate(), {.z_m = 5.0});
  world->start();
  EXPECT_NEAR(*world->ray_distance(id, {0, 0, 4}, {0, 0, -1}, 10), 3, 1e-9);
  for (int i = 0; i < 500; ++i) world->advance(1e-3);
  EXPECT_NEAR(*world->ray_distance(id, {-1.6, 0, 4}, {0, 0, -1}, 10), 4, 1e-9) << "it has gone";
}

class ActorFile : public testing::Test {
 protected:
  WorldModel load(const std::string& inside) {
    return load_sdf_world(
        folder_.write("w.sdf", "<sdf version='1.6'>\n<world name='w'>\n<actor name='bus'>" +
                                   inside + "</actor></world></sdf>"),
        {});
  }
  cas::test::TemporaryFolder folder_;
};

const std::string kBody =
    "<link name='l'><pose>0 0 1 0 0 0</pose><collision name='c'><geometry><box><size>4 2 2</size>"
    "</box></geometry></collision></link>";

TEST_F(ActorFile, WithACollisionAndATrajectoryIsAMovingObstacle) {
  const WorldModel model =
      load("<pose>10 0 0 0 0 1.5707963</pose>" + kBody +
           "<script><loop>0</loop><delay_start>1</delay_start><trajectory id='0' type='drive'>"
           "<waypoint><time>0</time><pose>0 0 0 0 0 0</pose></waypoint>"
           "<waypoint><time>2</time><pose>6 0 0 0 0 0</pose></waypoint></trajectory></script>");
  EXPECT_THAT(model.warnings, IsEmpty());
  ASSERT_EQ(model.moving.size(), 1u);
  EXPECT_EQ(model.moving[0].name, "bus");
  EXPECT_EQ(model.moving[0].shapes.at(0).pose.translation().z(), 1);
  // Its waypoints are in its own frame, which looks north.
  EXPECT_LT((model.moving[0].path.at(2).p_WB - Vector3d(10, 3, 0)).norm(), 1e-6);
}

TEST_F(ActorFile, WithoutACollisionIsAPicture) {
  const WorldModel model = load("<skin><filename>walk.dae</filename></skin>");
  EXPECT_TRUE(model.moving.empty());
  EXPECT_THAT(model.warnings,
              Contains(HasSubstr("w.sdf:3: <actor name='bus'> has no <collision>")));
}

TEST_F(ActorFile, RefusesTimesThatDoNotRise) {
  const std::string path =
      "<script><trajectory id='0' type='drive'><waypoint><time>2</time><pose>0 0 0 0 0 0</pose>"
      "</waypoint><waypoint><time>2</time><pose>6 0 0 0 0 "
      "0</pose></waypoint></trajectory></script>";
  EXPECT_THAT(cas::test::refusal([&] { load(kBody + path); }),
              HasSubstr("w.sdf:3: <actor name='bus'>: the <time> of its waypoints"));
}

}  // namespace
}  // namespace cas::sim
