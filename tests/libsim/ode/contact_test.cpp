// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "libsim/core/run/sim_world.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/libsim/support/four_rotors.hpp"
#include "tests/support/refusal.hpp"

/// Asked by LeakSanitizer: an ODE that has given up keeps a job of the step that it left.
extern "C" [[gnu::visibility("default")]] const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:dxtemplateThreading"; }

namespace cas::sim {
namespace {

using test::crate;
using test::flat_world;
using test::kCrateMass;
using test::kCrateSize;
using test::kGravity;
using test::make_world;
using test::standing;
using test::started;
using test::tilt;

constexpr VehicleId kFirst{0};
constexpr VehicleId kSecond{1};
constexpr double kStep = 1e-3;
constexpr double kWeight = kCrateMass * kGravity;
constexpr double kSink = 2e-3;  // m: how deep the contact springs give

void run(SimWorld& world, double seconds, double step = kStep) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds / step)); ++i) world.advance(step);
}

TEST(Contact, StandsAtTheHeightItWasGiven) {
  const auto world =
      started(make_world(flat_world()), crate(), {.x_m = 1, .y_m = 2, .z_m = 0, .yaw_deg = 30});
  const BodyState& state = world->state(kFirst);
  EXPECT_NEAR(state.p_WB.z(), kCrateSize.z() / 2, kSink);
  EXPECT_NEAR(state.p_WB.x(), 1.0, 1e-9);
  world->advance(kStep);
  EXPECT_TRUE(world->in_contact(kFirst));
  EXPECT_LT(state.a_WB.norm(), 1e-3) << "an accelerometer reads +1 g from the first sample on";
}

TEST(Rest, DoesNotCreepUnderASteadySideForce) {
  struct RestCase {
    const char* name;
    int step_us;
  };
  const RestCase rows[] = {{"Step250us", 250}, {"Step1ms", 1000}, {"Step4ms", 4000}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const auto world = started(make_world(flat_world()), crate(), {});
    const Eigen::Vector3d start = world->state(kFirst).p_WB;
    const double dt = 1e-6 * row.step_us;
    for (int i = 0; i < static_cast<int>(60.0 / dt); ++i) {
      // A side force below friction that never holds quite still keeps the solver at work.
      const double f = 2.0 + 0.5 * std::sin(0.01 * i);
      world->add_wrench(kFirst, {{f, 0, 0}, Eigen::Vector3d::Zero()});
      world->advance(dt);
    }
    EXPECT_LT((world->state(kFirst).p_WB - start).head<2>().norm(), 1e-5);
    EXPECT_LT(tilt(world->state(kFirst)), 1e-2);
  }
}

TEST(Contact, AtRestItStandsStillToTheBit) {
  const auto world = started(make_world(flat_world()), crate(), {});
  run(*world, 1.0);
  const BodyState before = world->state(kFirst);
  run(*world, 10.0);
  EXPECT_EQ(world->state(kFirst).p_WB, before.p_WB);
  EXPECT_EQ(world->state(kFirst).q_WB.coeffs(), before.q_WB.coeffs());
}

TEST(Contact, ABoxRestsHalfOverTheEdgeOfABox) {
  WorldModel model;
  model.gravity_W = {0, 0, -kGravity};
  model.statics.push_back(standing("table", Box{{4, 4, 1}}, {2, 0, -0.5}));
  for (const double beyond_m : {0.02, 0.05, 0.09}) {
    const auto world = started(make_world(model), crate({0.24, 0.24, 0.12}),
                               {.x_m = beyond_m, .z_m = 0, .yaw_deg = 30});
    run(*world, 3.0);
    double fastest = 0;
    for (int i = 0; i < 200; ++i) {
      world->advance(kStep);
      const BodyState& state = world->state(kFirst);
      fastest = std::max(fastest, std::max(state.v_WB.norm(), state.w_WB_B.norm()));
    }
    EXPECT_LT(fastest, 1e-6) << beyond_m;
    EXPECT_GT(world->state(kFirst).p_WB.z(), 0.05) << beyond_m << ": it has fallen";
  }
}

TEST(Contact, ASolverThatGivesUpIsARefusalAndNotTheEndOfTheProgram) {
  const auto world = make_world(flat_world());
  VehicleModel heavy = crate();
  heavy.mass = MassProperties(1e160, 1e160 * Eigen::Matrix3d::Identity());
  world->add_vehicle(heavy, {});
  EXPECT_THAT(cas::test::refusal([&] {
                world->start();
                run(*world, 0.5);
              }),
              testing::HasSubstr("the contact solver has given up (assertion "));
}

TEST(Contact, SlidesByCoulombFriction) {
  constexpr double kFriction = 0.4;
  for (const double heading : {0.0, 0.6, M_PI / 4}) {
    const auto world = started(make_world(flat_world(kFriction)), crate(), {});
    run(*world, 0.5);
    const Eigen::Vector3d direction(std::cos(heading), std::sin(heading), 0);
    // Pushed to 2 m/s within one step, then left alone.
    world->add_wrench(kFirst, {kCrateMass * 2.0 / kStep * direction, Eigen::Vector3d::Zero()});
    world->advance(kStep);
    const double speed = world->state(kFirst).v_WB.norm();
    const Eigen::Vector3d start = world->state(kFirst).p_WB;
    ASSERT_GT(speed, 1.5);
    run(*world, 1.5);
    const double slid = (world->state(kFirst).p_WB - start).norm();
    const double expected = speed * speed / (2 * kFriction * kGravity);
    EXPECT_NEAR(slid, expected, 0.02 * expected) << "heading " << heading;
    EXPECT_LT(world->state(kFirst).v_WB.norm(), 1e-6);
  }
}

TEST(Contact, HoldsOnASlopeBelowTheFrictionAngleAndSlidesAbove) {
  for (const double degrees : {20.0, 40.0}) {  // friction 0.6: 31 degrees
    WorldModel model;
    model.gravity_W = {0, 0, -kGravity};
    Shape slope = standing("slope", Plane{}, Eigen::Vector3d::Zero(), 0.6);
    const Eigen::AngleAxisd turn(degrees * M_PI / 180, Eigen::Vector3d::UnitY());
    slope.pose.linear() = turn.toRotationMatrix();
    model.statics.push_back(slope);
    const auto world = started(make_world(model), crate(), {.z_m = 0.25});
    run(*world, 3.0);  // lands flat
    const Eigen::Vector3d early = world->state(kFirst).p_WB;
    run(*world, 1.0);
    const double moved = (world->state(kFirst).p_WB - early).norm();
    if (degrees < 31) {
      EXPECT_LT(moved, 1e-6);
    } else {
      EXPECT_GT(moved, 1.0);
    }
  }
}

TEST(Contact, TipsOverWhenPushedAboveItsCentre) {
  // A tall crate tips when the push's moment about the far edge exceeds the weight's.
  const Eigen::Vector3d tall(0.2, 0.2, 1.0);
  const double needed = kWeight * 0.1 / 0.9;  // at 0.9 m height
  for (const double part : {0.8, 1.3}) {
    const auto world = started(make_world(flat_world()), crate(tall), {});
    for (int i = 0; i < 1500; ++i) {
      const Eigen::Vector3d push(part * needed, 0, 0);
      world->add_wrench(kFirst, {push, Eigen::Vector3d(0, 0.4 * part * needed, 0)});
      world->advance(kStep);
    }
    if (part < 1) {
      EXPECT_LT(tilt(world->state(kFirst)), 0.01);
    } else {
      EXPECT_GT(tilt(world->state(kFirst)), 1.0);
    }
  }
}

TEST(Contact, LandsWithoutBouncingAndRests) {
  const auto world = started(make_world(flat_world()), crate(), {.z_m = 0.05});
  double highest_after = 0;
  bool landed = false;
  for (int i = 0; i < 3000; ++i) {
    world->advance(kStep);
    landed = landed || world->in_contact(kFirst);
    if (landed && i > 300) highest_after = std::max(highest_after, world->state(kFirst).p_WB.z());
  }
  EXPECT_TRUE(landed);
  EXPECT_LT(highest_after, kCrateSize.z() / 2 + 1e-3);
  EXPECT_EQ(world->state(kFirst).v_WB.norm(), 0.0);
}

TEST(Contact, CrashStaysAboveTheGround) {
  const auto world = make_world(flat_world());
  world->add_vehicle(crate(), {.z_m = 20});  // arrives at 20 m/s
  world->start();
  double lowest = 1;
  for (int i = 0; i < 5000; ++i) {
    world->add_wrench(kFirst, {Eigen::Vector3d::Zero(), {0.02, 0.03, 0}});  // tumbling
    world->advance(kStep);
    lowest = std::min(lowest, world->state(kFirst).p_WB.z());
  }
  EXPECT_GT(lowest, 0.02);
  EXPECT_LT(world->state(kFirst).p_WB.z(), 1.0);
}

TEST(Contact, TakeOffIsSeamless) {
  const auto world = make_world(flat_world());
  const VehicleId id = world->add_vehicle(crate(), {});
  test::SteadyThrust thrust(0);
  world->add_force_model(id, thrust);
  world->start();
  run(*world, 0.2);
  // Thrust ramps through the weight; once off, the climb is that of the net force.
  double previous_z = world->state(id).p_WB.z();
  double largest_jump = 0;
  for (int i = 0; i < 1000; ++i) {
    thrust.set(1.2 * kWeight * i / 1000.0);
    world->advance(kStep);
    const double z = world->state(id).p_WB.z();
    largest_jump = std::max(largest_jump, std::abs(z - previous_z));
    previous_z = z;
  }
  EXPECT_FALSE(world->in_contact(id));
  EXPECT_LT(largest_jump, 2e-4);  // its own speed of at most 0.2 m/s, no leap
  const double a = world->state(id).a_WB.z();
  EXPECT_NEAR(a, 0.2 * kGravity, 0.02);
}

TEST(Contact, FreeFlightNearTheGroundIsOurs) {
  // Half a metre up, within reach of nothing: the same bits as without any ground.
  WorldModel empty;
  empty.gravity_W = {0, 0, -kGravity};
  const auto with = make_world(flat_world());
  const auto without = make_world(empty);
  for (SimWorld* world : {with.get(), without.get()}) {
    world->add_vehicle(crate(), {.z_m = 3});
    world->start();
    run(*world, 0.5);
  }
  EXPECT_EQ(with->state(kFirst).p_WB, without->state(kFirst).p_WB);
}

TEST(Contact, ObstaclesStopTheVehicle) {
  WorldModel model = flat_world();
  model.statics.push_back(standing("wall", Box{{0.2, 4, 2}}, {2, 0, 1}));
  const auto world = make_world(model);
  const VehicleId id = world->add_vehicle(crate(), {.z_m = 0.5});
  test::SteadyThrust hover(kWeight);
  world->add_force_model(id, hover);
  world->start();
  for (int i = 0; i < 4000; ++i) {
    world->add_wrench(id, {{0.5, 0, 0}, Eigen::Vector3d::Zero()});
    world->advance(kStep);
    ASSERT_LT(world->state(id).p_WB.x(), 1.9 - kCrateSize.x() / 2 + 0.02);
  }
  EXPECT_GT(world->state(id).p_WB.x(), 1.0);
}

TEST(Contact, VehiclesCollideWithEachOther) {
  const auto world = make_world(flat_world());
  world->add_vehicle(crate(), {});
  world->add_vehicle(crate(), {.x_m = 0.02, .z_m = 1.0});  // falls on the first
  world->start();
  run(*world, 3.0);
  EXPECT_NEAR(world->state(kSecond).p_WB.z(), 1.5 * kCrateSize.z(), 2 * kSink);
  EXPECT_NEAR(world->state(kFirst).p_WB.z(), 0.5 * kCrateSize.z(), 2 * kSink);
  EXPECT_EQ(world->state(kSecond).v_WB.norm(), 0.0) << "the stack comes to rest";
}

TEST(Contact, RaysFindTheNearestSurfaceThatIsNotTheirOwn) {
  WorldModel model = flat_world();
  model.statics.push_back(standing("table", Box{{1, 1, 0.2}}, {5, 0, 0.9}));
  const auto world = make_world(model);
  const VehicleId id = world->add_vehicle(crate(), {.z_m = 3});
  world->add_vehicle(crate(), {.x_m = 0, .y_m = 4, .z_m = 3});
  world->start();
  const Eigen::Vector3d p = world->state(id).p_WB;
  const Eigen::Vector3d down(0, 0, -1);
  EXPECT_NEAR(world->ray_distance(id, p, down, 10).value(), p.z(), 1e-9);
  EXPECT_NEAR(world->ray_distance(id, {5, 0, 3}, down, 10).value(), 2.0, 1e-9);
  EXPECT_NEAR(world->ray_distance(id, p, {0, 1, 0}, 10).value(), 4 - 0.2, 1e-9);
  EXPECT_FALSE(world->ray_distance(id, p, down, 1.0));
  EXPECT_FALSE(world->ray_distance(id, p, {0, 0, 1}, 100));
}

TEST(Contact, HeightAboveGroundCountsFromTheSurfaceBelow) {
  WorldModel model = flat_world();
  model.statics.push_back(standing("roof", Box{{2, 2, 1}}, {3, 0, 0.5}));
  const auto world = make_world(model);
  world->add_vehicle(crate(), {.x_m = 0, .z_m = 4});
  world->add_vehicle(crate(), {.x_m = 3, .z_m = 4});
  world->start();
  EXPECT_NEAR(world->environment(kFirst).height_above_ground_m, 4.05, 1e-9);
  EXPECT_NEAR(world->environment(kSecond).height_above_ground_m, 3.05, 1e-9);
}

TEST(Contact, MeshesCollide) {
  auto pyramid = std::make_shared<TriangleMesh>();
  pyramid->vertices = {{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}, {0, 0, 0.5}};
  pyramid->triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  WorldModel model;
  model.gravity_W = {0, 0, -kGravity};
  model.statics.push_back(standing("pyramid", Mesh{pyramid}));
  const auto world = started(make_world(model), crate(), {.x_m = 2, .z_m = 1});
  run(*world, 3.0);
  const double surface = 0.5 * (1 - world->state(kFirst).p_WB.x() / 5);
  EXPECT_NEAR(world->state(kFirst).p_WB.z(), surface + kCrateSize.z() / 2, 0.01);
  EXPECT_LT(world->state(kFirst).v_WB.norm(), 1e-3);
}

TEST(OdeIntegrator, FallsAsFirstOrderDoes) {
  const auto world = started(make_world(flat_world(), Integrator::kOde), crate(), {.z_m = 10});
  const double start = world->state(kFirst).p_WB.z();
  run(*world, 1.0);
  const double error = world->state(kFirst).p_WB.z() - (start - 0.5 * kGravity);
  EXPECT_NEAR(error, -0.5 * kGravity * kStep, 1e-6);  // g h t / 2
}

TEST(World, ResetRepeatsTheSameRunBitForBit) {
  const auto world = make_world(flat_world());
  world->add_vehicle(crate(), {.z_m = 0.3});
  test::FourRotors rotors(Eigen::Vector4d(300, 310, 290, 305));
  world->add_force_model(kFirst, rotors);
  world->start();
  const auto fly = [&] {
    std::vector<double> trace;
    for (int i = 0; i < 2000; ++i) {
      world->advance(kStep);
      trace.push_back(world->state(kFirst).p_WB.sum() + world->state(kFirst).w_WB_B.sum());
    }
    return trace;
  };
  const auto first = fly();
  world->reset();
  EXPECT_EQ(fly(), first);
}

TEST(World, ScaledMassFallsAlikeAndIsUndoneByOne) {
  const auto world = started(make_world(flat_world()), crate(), {.z_m = 3});
  world->scale_mass(kFirst, 0.5);
  EXPECT_DOUBLE_EQ(world->mass_kg(kFirst), 0.5 * kCrateMass);
  world->add_wrench(kFirst, {{kCrateMass, 0, 0}, Eigen::Vector3d::Zero()});
  world->advance(kStep);
  EXPECT_NEAR(world->state(kFirst).a_WB.x(), 2.0, 1e-9);
  world->scale_mass(kFirst, 1.0);
  EXPECT_DOUBLE_EQ(world->mass_kg(kFirst), kCrateMass);
}

}  // namespace
}  // namespace cas::sim
