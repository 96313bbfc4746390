// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/world_loader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "libsim/core/load/mesh_file.hpp"
#include "libsim/core/run/sim_runner.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using namespace std::chrono_literals;

const std::filesystem::path kWorlds = test::kSourceDir / "config/worlds";
const std::filesystem::path kData = test::kSourceDir / "tests/libsim/data";

const Shape* find(const WorldModel& model, const std::string& name) {
  for (const Shape& shape : model.statics) {
    if (shape.name == name) return &shape;
  }
  return nullptr;
}

TEST(SdfWorld, ShippedWorldsLoadWithoutAWarning) {
  for (const char* name : {"empty.sdf", "village.sdf"}) {
    const WorldModel model = load_sdf_world(kWorlds / name, {});
    EXPECT_THAT(model.warnings, IsEmpty()) << name;
    EXPECT_EQ(model.gravity_W.z(), -9.80665);
    ASSERT_TRUE(model.home);
    EXPECT_EQ(model.home->alt_m, 488.0);
    EXPECT_EQ(model.step, 1ms);
    EXPECT_TRUE(find(model, "ground_plane/collision"));
  }
}

TEST(SdfWorld, VillageHasHousesTreesCarsAndWind) {
  const WorldModel model = load_sdf_world(kWorlds / "village.sdf", {});
  EXPECT_EQ(model.wind_W, Eigen::Vector3d(1.5, 0.5, 0));
  EXPECT_TRUE(find(model, "car_2/cabin"));
  const Shape* const roof = find(model, "house_1/roof");
  ASSERT_TRUE(roof);
  EXPECT_EQ(std::get<Mesh>(roof->geometry).triangles->triangles.size(), 8u);
  const Shape* const ramp = find(model, "ramp/plate");
  ASSERT_TRUE(ramp);
  EXPECT_EQ(ramp->surface.friction, 0.7);
  EXPECT_NEAR(ramp->pose.linear().col(0).z(), std::sin(0.3), 1e-9) << "pitch -0.3 lifts x";
}

TEST(SdfWorld, ClassicFileLoadsAndEachOmissionIsNamedOnce) {
  const WorldModel model = load_sdf_world(kData / "classic.world", {kWorlds / "models"});
  EXPECT_EQ(model.gravity_W.z(), -9.8066) << "of <physics>, as SDF 1.5 has it";
  EXPECT_EQ(model.step, 4ms);
  EXPECT_EQ(model.real_time_factor, 2.0);
  EXPECT_FALSE(model.home);
  EXPECT_TRUE(find(model, "crate/box"));

  EXPECT_EQ(model.warnings.size(), 9u);
  EXPECT_THAT(model.warnings, Each(HasSubstr("classic.world: ")));
  for (const char* sentence : {"asphalt_plane", "'crate' is not static", "<sensor>", "'pipe/egg'",
                               "'pipe/dae'", "'pipe/shed' names a <submesh>", "nothing bounces",
                               "<actor> is left out", "<plugin> is left out"}) {
    EXPECT_THAT(model.warnings, Contains(HasSubstr(sentence)));
  }
}

TEST(SdfWorld, PosesChainThroughModelLinkAndCollision) {
  const WorldModel model = load_sdf_world(kData / "classic.world", {kWorlds / "models"});
  const Shape* const tube = find(model, "pipe/tube");
  ASSERT_TRUE(tube);
  // Model at (0 5 1), link at (0 0 1) rolled by 90 degrees, collision 0.5 along the link's z.
  EXPECT_LT((tube->pose.translation() - Eigen::Vector3d(0, 4.5, 2)).norm(), 1e-4);
  EXPECT_EQ(tube->surface.friction, 0.3);
}

TEST(SdfWorld, ColladaMeshesCollide) {
  const WorldModel model = load_sdf_world(kData / "classic.world", {kWorlds / "models"});
  const Shape* const shed = find(model, "pipe/shed");
  ASSERT_TRUE(shed);
  const TriangleMesh& mesh = *std::get<Mesh>(shed->geometry).triangles;
  EXPECT_EQ(mesh.triangles.size(), 4u);
  Eigen::Vector3d centre;
  EXPECT_LT((bounding_box(mesh, centre).size_m - Eigen::Vector3d(2, 3, 1)).norm(), 1e-9);
}

TEST(SdfWorld, RefusesWhatIsNoWorld) {
  const cas::test::TemporaryFolder folder;
  const auto load = [&](const std::string& text) {
    return test::refusal([&] { load_sdf_world(folder.write("w.sdf", text), {}); });
  };
  EXPECT_THAT(load("no xml"), HasSubstr("w.sdf: holds no SDF world"));
  EXPECT_THAT(load("<sdf version='1.6'><model name='m'><link name='l'/></model></sdf>"),
              HasSubstr("holds no SDF world"));
  EXPECT_THAT(test::refusal([] { load_sdf_world("/nowhere.sdf", {}); }),
              HasSubstr("/nowhere.sdf: world cannot be read"));
}

TEST(SdfWorld, LeavesOutAStepOfZero) {
  const cas::test::TemporaryFolder folder;
  const WorldModel world = load_sdf_world(
      folder.write("w.sdf",
                   "<sdf version='1.6'><world name='w'><physics name='p' type='ode'>"
                   "<max_step_size>0</max_step_size><real_time_factor>1</real_time_factor>"
                   "<real_time_update_rate>1000</real_time_update_rate></physics></world></sdf>"),
      {});
  EXPECT_FALSE(world.step.has_value());
  EXPECT_THAT(world.warnings, Contains(HasSubstr("<max_step_size> must lie in")));
}

TEST(SdfWorld, RunsWithItsOwnHomeStepAndFactor) {
  const std::string world = "world: " + (kWorlds / "village.sdf").string() + "\n";
  SimRunner runner(SimConfig::parse(base::ConfigNode::parse(
      "schema: 1\ndecimal_year: 2026.5\n" + world + "vehicles:\n" + test::vehicle("a"), "s.yaml")));
  runner.start();
  for (int i = 0; i < 100; ++i) runner.step();
  EXPECT_EQ(runner.step_size(), 1ms);
  EXPECT_EQ(runner.world().projection().home().alt_m, 488.0);
  EXPECT_EQ(runner.world().environment(VehicleId{0}).wind_W.x(), 1.5);
  EXPECT_TRUE(runner.world().in_contact(VehicleId{0}));
}

TEST(ShippedWorlds, LoadWithVehiclesAndPlugins) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kWorlds)) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path());
    const SimRunner runner(
        SimConfig::load(entry.path()),
        {.output_dir = ".",
         .plugin_dirs = {std::filesystem::path(cas::test::binary_dir()) / "plugins"}});
    EXPECT_FALSE(runner.vehicle_names().empty());
    ++files;
  }
  EXPECT_GE(files, 3);
}

TEST(SdfWorld, NeedsAHomeFromSomewhere) {
  const std::string world = "world: " + (kData / "classic.world").string() + "\n";
  EXPECT_THAT(
      test::refusal([&] {
        const SimRunner runner(SimConfig::parse(base::ConfigNode::parse(
            "schema: 1\ndecimal_year: 2026.5\n" + world + "vehicles:\n" + test::vehicle("a"),
            "s.yaml")));
      }),
      HasSubstr("has no <spherical_coordinates>"));
}

}  // namespace
}  // namespace cas::sim
