// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/world_loader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "base/config/model_uri.hpp"
#include "base/error.hpp"
#include "libsim/core/load/mesh_file.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/run/sim_runner.hpp"
#include "libsim/core/run/start.hpp"
#include "tests/libsim/support/sdf_elements.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using test::load_elements;
using test::obstacle;
using test::world_of;
using testing::AllOf;
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

WorldModel classic_world() {
  return load_sdf_world(kData / "classic.world", {kWorlds / "models"}, Missing::kIgnore);
}

TEST(SdfWorld, ClassicFileLoadsAndEachOmissionIsNamedWithItsLine) {
  const WorldModel model = classic_world();
  EXPECT_EQ(model.gravity_W.z(), -9.8066) << "of <physics>, as SDF 1.5 has it";
  EXPECT_EQ(model.step, 4ms);
  EXPECT_EQ(model.real_time_factor, 2.0);
  EXPECT_FALSE(model.home);
  EXPECT_TRUE(find(model, "crate/box"));

  EXPECT_THAT(model.warnings, Each(HasSubstr("classic.world:")));
  for (const char* sentence :
       {":6: model model://asphalt_plane is nowhere", ":21: model 'crate' is not <static>",
        ":25: model 'crate': <sensor name='s'> is left out",
        ":41: collision 'pipe/egg': <ellipsoid>", ":42: mesh model://nowhere/x.dae is nowhere",
        ":44: collision 'pipe/shed' names a <submesh>",
        "'pipe/tube': <restitution_coefficient> is left out: nothing bounces",
        ":20: <actor name='walker'>", ":19: <plugin name='ros_link'> is left out"}) {
    EXPECT_THAT(model.warnings, Contains(HasSubstr(sentence)));
  }
}

TEST(SdfWorld, PosesChainThroughModelLinkAndCollision) {
  const WorldModel model = classic_world();
  const Shape* const tube = find(model, "pipe/tube");
  ASSERT_TRUE(tube);
  // Model at (0 5 1), link at (0 0 1) rolled by 90 degrees, collision 0.5 along the link's z.
  EXPECT_LT((tube->pose.translation() - Eigen::Vector3d(0, 4.5, 2)).norm(), 1e-4);
  EXPECT_EQ(tube->surface.friction, 0.3);
}

TEST(SdfWorld, ColladaMeshesCollide) {
  const WorldModel model = classic_world();
  const Shape* const shed = find(model, "pipe/shed");
  ASSERT_TRUE(shed);
  const TriangleMesh& mesh = *std::get<Mesh>(shed->geometry).triangles;
  EXPECT_EQ(mesh.triangles.size(), 4u);
  Eigen::Vector3d centre;
  EXPECT_LT((bounding_box(mesh, centre).size_m - Eigen::Vector3d(2, 1, 3)).norm(), 1e-9)
      << "its y is up, and Gazebo does not turn it";
  EXPECT_THAT(model.warnings,
              Contains(AllOf(HasSubstr("classic.world:43: collision 'pipe/shed': "),
                             HasSubstr("shed.dae:6: <up_axis> Y_UP does not turn the mesh"))));
  const WorldModel turned = load_world({.sdf = kData / "classic.world",
                                        .model_path = {kWorlds / "models"},
                                        .missing = Missing::kIgnore,
                                        .up_axis = UpAxis::kApplied});
  const Mesh& upright = std::get<Mesh>(find(turned, "pipe/shed")->geometry);
  EXPECT_LT((bounding_box(*upright.triangles, centre).size_m - Eigen::Vector3d(2, 3, 1)).norm(),
            1e-9);
}

TEST(SdfWorld, RefusesWhatIsNoWorld) {
  const cas::test::TemporaryFolder folder;
  const auto load = [&](const std::string& text) {
    return test::refusal([&] { load_sdf_world(folder.write("w.sdf", text), {}); });
  };
  EXPECT_THAT(load("no xml"), HasSubstr("w.sdf:1: "));
  EXPECT_THAT(load("<sdf version='1.6'>\n<world name='w'>\n</sdf>"),
              AllOf(HasSubstr("w.sdf:3: mismatched tag"), HasSubstr("; mend that place: ")));
  EXPECT_THAT(load("<sdf version='1.6'><model name='m'><link name='l'/></model></sdf>"),
              AllOf(HasSubstr("holds no SDF world: it is the model 'm' alone"),
                    HasSubstr("<include><uri>")));
  EXPECT_THAT(load("<sdf version='1.6'/>"), AllOf(HasSubstr("holds no SDF world: "),
                                                  HasSubstr("as in config/worlds/village.sdf")));
  EXPECT_THAT(load("<robot name='r'/>"), HasSubstr("it is a URDF"));
  EXPECT_THAT(load("<mesh/>"), HasSubstr("its outermost element is <mesh>, not <sdf>"));
  EXPECT_THAT(load("<sdf version='1.6'><% n = 3 %><world name='w'/></sdf>"),
              HasSubstr("it is a template"));
  EXPECT_THAT(test::refusal([] { load_sdf_world("/nowhere.sdf", {}); }),
              HasSubstr("/nowhere.sdf: world cannot be read"));
}

TEST(SdfWorld, RefusesToGoWithoutAModelAndSaysWhereItLooked) {
  const cas::test::TemporaryFolder folder;
  const std::string trees =
      "<include><uri>model://oak</uri></include>\n<include><uri>https://"
      "fuel.gazebosim.org/1.0/OpenRobotics/models/Elm</uri></include>";
  const auto file = folder.write("w.sdf", world_of(trees + obstacle("")));
  const std::string refusal = test::refusal([&] { load_sdf_world(file, {"/my/models"}); });
  EXPECT_THAT(refusal, HasSubstr("w.sdf:3: model model://oak, model https://"));
  EXPECT_THAT(refusal,
              HasSubstr("w.sdf:4) are nowhere to be found; looked for the first of them at " +
                        (folder / "oak").string() + ", /my/models/oak"));
  EXPECT_THAT(refusal, HasSubstr("--ignore-missing"));
  const WorldModel without = load_sdf_world(file, {}, Missing::kIgnore);
  EXPECT_EQ(without.warnings.size(), 2u);
  EXPECT_THAT(without.warnings,
              Contains(HasSubstr("model://oak is nowhere to be found; left out")));

  const auto nothing_else = folder.write("trees.sdf", world_of(trees));
  EXPECT_THAT(test::refusal([&] { load_sdf_world(nothing_else, {}, Missing::kIgnore); }),
              HasSubstr("nothing is left that could carry a vehicle"));
}

TEST(SdfWorld, AThirdSlashBehindModelIsNoRoot) {
  EXPECT_EQ(base::places_of_model_file("model:///oak/oak.dae", "/w", {}).at(0).string(),
            "/w/oak/oak.dae");
}

TEST(SdfWorld, AFileWithoutAFolderIsInTheWorkingFolder) {
  const std::string here = std::filesystem::current_path().string();
  for (const char* uri : {"oak.dae", "model://oak/oak.dae", "package://oak/oak.dae"}) {
    EXPECT_THAT(base::searched_places(uri, "", {}), HasSubstr(here)) << uri;
  }
}

TEST(SdfWorld, AModelInAFolderAboveIsFound) {
  const cas::test::TemporaryFolder folder;
  folder.write("models/box/meshes/box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const char* uri : {"model://box/meshes/box.obj", "package://box/meshes/box.obj",
                          "package://lost/meshes/box.obj"}) {
    const auto file = folder.write(
        "models/box/worlds/w.sdf",
        world_of("<model name='m'><static>1</static><link name='l'><collision "
                 "name='c'><geometry><mesh><uri>" +
                 std::string(uri) + "</uri></mesh></geometry></collision></link></model>"));
    EXPECT_EQ(load_sdf_world(file, {}).statics.size(), 1u) << uri;
  }
}

TEST(SdfWorld, FindsAFuelModelByItsNameInTheModelPath) {
  const cas::test::TemporaryFolder folder;
  folder.write(
      "models/Elm/model.config",
      "<model><name>Elm</name><version>1</version><sdf version='1.6'>model.sdf</sdf></model>");
  folder.write(
      "models/Elm/model.sdf", "<sdf version='1.6'>" + [] {
        std::string model = obstacle("");
        return model.erase(model.find("<surface>"), std::string("<surface></surface>").size());
      }() + "</sdf>");
  const WorldModel model = load_sdf_world(
      folder.write("w.sdf", world_of("<include><uri>https://fuel.gazebosim.org/1.0/OpenRobotics/"
                                     "models/Elm</uri></include>")),
      {});
  EXPECT_EQ(model.statics.size(), 1u);
}

TEST(SdfWorld, ReadsStiffnessAndDampingOfASurface) {
  const auto surface_of = [](const std::string& ode) {
    const WorldModel model = load_elements(obstacle("<contact><ode>" + ode + "</ode></contact>"));
    EXPECT_THAT(model.warnings, IsEmpty());
    return model.statics.at(0).surface;
  };
  EXPECT_EQ(surface_of("<kp>2e5</kp><kd>30</kd>").stiffness_n_m, 2e5);
  EXPECT_EQ(surface_of("<kp>2e5</kp><kd>30</kd>").damping_n_s_m, 30.0);
  EXPECT_EQ(surface_of("<kp>2e5</kp>").damping_n_s_m, std::nullopt);
  EXPECT_EQ(surface_of("").stiffness_n_m, std::nullopt);
}

TEST(SdfWorld, WarnsOfWhatItDoesNotDoByNameAndLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"<friction><ode><mu>0.5</mu><mu2>0.8</mu2></ode></friction>",
       "collision 'm/c': <mu2> 0.8 is left out: <mu> 0.5 holds in every direction"},
      {"<friction><ode><mu2>0.8</mu2><fdir1>1 0 0</fdir1></ode></friction>",
       "collision 'm/c': <fdir1> is left out"},
      {"<friction><ode><slip1>0.1</slip1></ode></friction>", "<slip1> is left out"},
      {"<friction><bullet><friction>0.4</friction></bullet></friction>", "of <bullet> is left out"},
      {"<friction><torsional><coefficient>1</coefficient></torsional></friction>", "<torsional>"},
      {"<bounce><restitution_coefficient>0.4</restitution_coefficient></bounce>",
       "nothing bounces"},
      {"<contact><ode><max_vel>0.1</max_vel></ode></contact>", "<max_vel> is left out"}};
  for (const auto& [surface, sentence] : cases) {
    const WorldModel model = load_elements(obstacle(surface));
    EXPECT_THAT(model.warnings, Contains(AllOf(HasSubstr("w.sdf:4: "), HasSubstr(sentence))));
    EXPECT_EQ(model.statics.size(), 1u) << surface;
  }
  EXPECT_THAT(load_elements(obstacle("<friction><ode><mu>0.5</mu><mu2>0.5</mu2></ode></friction>"))
                  .warnings,
              IsEmpty())
      << "what changes nothing";
}

TEST(SdfWorld, HasTheFieldAndTheAirOfTheFile) {
  const WorldModel model = load_elements(
      "<magnetic_field>6e-6 2.3e-5 -4.2e-5</magnetic_field><atmosphere type='adiabatic'>"
      "<temperature>310</temperature><temperature_gradient>-0.0098</temperature_gradient>"
      "<pressure>99000</pressure></atmosphere>");
  EXPECT_THAT(model.warnings, IsEmpty());
  ASSERT_TRUE(model.magnetic_field_W.has_value());
  EXPECT_TRUE(model.magnetic_field_W->isApprox(Eigen::Vector3d(0.06, 0.23, -0.42), 1e-9))
      << "gauss";
  EXPECT_DOUBLE_EQ(model.atmosphere.temperature_K, 310);
  EXPECT_DOUBLE_EQ(model.atmosphere.temperature_gradient_K_m, -0.0098);
  EXPECT_DOUBLE_EQ(model.atmosphere.pressure_Pa, 99000);
  EXPECT_TRUE(classic_world().magnetic_field_W.has_value()) << "below <physics>, as SDF 1.5 has it";
}

TEST(SdfWorld, HasTheEarthsFieldAndTheStandardAirWhereTheFileSaysNothing) {
  for (const char* elements : {"", "<atmosphere type='adiabatic'/>"}) {
    const WorldModel model = load_elements(elements);
    EXPECT_THAT(model.warnings, IsEmpty());
    EXPECT_FALSE(model.magnetic_field_W.has_value()) << "not SDF's default";
    EXPECT_DOUBLE_EQ(model.atmosphere.temperature_K, 288.15);
    EXPECT_DOUBLE_EQ(model.atmosphere.temperature_gradient_K_m, -0.0065);
    EXPECT_DOUBLE_EQ(model.atmosphere.pressure_Pa, 101325);
  }
}

TEST(SdfWorld, LeavesOutAFieldAndAirThatCannotBe) {
  const WorldModel field = load_elements("<magnetic_field>0.06 0.23 -0.42</magnetic_field>");
  EXPECT_FALSE(field.magnetic_field_W.has_value());
  EXPECT_THAT(field.warnings, Contains(HasSubstr("w.sdf:3: <magnetic_field> must lie in")));
  const WorldModel air =
      load_elements("<atmosphere type='adiabatic'><temperature>15</temperature></atmosphere>");
  EXPECT_DOUBLE_EQ(air.atmosphere.temperature_K, 288.15);
  EXPECT_THAT(air.warnings, Contains(HasSubstr("w.sdf:3: <atmosphere>: <temperature> must lie")));
}

TEST(SdfWorld, NamesThreeOfAKindAndCountsTheOthers) {
  std::string elements;
  for (int i = 0; i < 5; ++i) {
    elements += "<model name='m" + std::to_string(i) + "'><link name='l'/></model>\n";
  }
  const WorldModel model = load_elements(elements);
  ASSERT_EQ(model.warnings.size(), 3u);
  EXPECT_THAT(model.warnings[2], HasSubstr("w.sdf:5: model 'm2' is not <static>; it stands still "
                                           "here; and 2 more places like this"));
}

TEST(SdfWorld, WhatTouchesNothingIsNoObstacle) {
  EXPECT_TRUE(load_elements(obstacle("<contact><collide_bitmask>0</collide_bitmask></contact>"))
                  .statics.empty());
  EXPECT_TRUE(
      load_elements(
          obstacle("<contact><collide_without_contact>1</collide_without_contact></contact>"))
          .statics.empty());
  EXPECT_FALSE(load_elements(obstacle("<contact><collide_bitmask>2</collide_bitmask></contact>"))
                   .statics.empty());
}

TEST(SdfWorld, WarnsOfASecondWorld) {
  const cas::test::TemporaryFolder folder;
  const WorldModel model = load_sdf_world(
      folder.write("w.sdf", "<sdf version='1.6'><world name='a'/>\n<world name='b'/></sdf>"), {});
  EXPECT_EQ(model.name, "a");
  EXPECT_THAT(model.warnings, Contains(HasSubstr("w.sdf:2: the <world> 'b' is left out")));
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

/// A run in a world of these elements; its only vehicle starts at this pose.
SimConfig config_in(const cas::test::TemporaryFolder& folder, const std::string& elements,
                    const std::string& pose) {
  const auto world = folder.write("w.sdf", world_of("<gravity>0 0 -9.8</gravity>" + elements));
  std::string vehicle = test::vehicle("a");
  SimConfig config = SimConfig::parse(base::ConfigNode::parse(
      "schema: 1\ndecimal_year: 2026.5\nhome: {lat_deg: 47, lon_deg: 8, alt_m: 488}\nworld: " +
          world.string() + "\nvehicles:\n" + vehicle,
      "s.yaml"));
  const base::ConfigNode node = base::ConfigNode::parse(pose);
  config.vehicles[0].pose = {.x_m = node.require<double>("x_m"),
                             .z_m = node.require<double>("z_m")};
  return config;
}

TEST(SdfWorld, AVehicleFliesInTheFieldAndTheAirOfTheFile) {
  const cas::test::TemporaryFolder folder;
  SimRunner runner(config_in(folder,
                             obstacle("<friction/>") +
                                 "<magnetic_field>6e-6 2.3e-5 -4.2e-5</magnetic_field>"
                                 "<atmosphere type='adiabatic'><temperature>310</temperature>"
                                 "<temperature_gradient>-0.0098</temperature_gradient>"
                                 "<pressure>99000</pressure></atmosphere>",
                             "{x_m: 0, z_m: 12}"));
  runner.start();
  const World& world = runner.world();
  EXPECT_NEAR(world.magnetic_field_W().value_or(Eigen::Vector3d::Zero()).y(), 0.23, 1e-12);
  // 500 m above sea level: p / (R T), with p of the closed form
  const double alt_m = 488 + world.state(VehicleId{0}).p_WB.z();
  const double kelvin = 310 - 0.0098 * alt_m;
  const double pascal = 99000 * std::pow(kelvin / 310, 9.80665 / (287.053 * 0.0098));
  EXPECT_NEAR(world.environment(VehicleId{0}).air_density_kg_m3, pascal / (287.053 * kelvin), 1e-5);
  EXPECT_EQ(world.atmosphere().pressure_Pa, 99000);
}

const std::string kAsphalt =  // up to 0.05 m
    "<model name='asphalt'><static>1</static><link name='l'><collision name='c'><geometry><box>"
    "<size>200 200 .1</size></box></geometry></collision></link></model>";

TEST(SdfWorld, AStartInsideAnObstacleIsRefusedWithTheHeightAboveIt) {
  const cas::test::TemporaryFolder folder;
  const std::string box = obstacle("<friction/>");  // from -0.5 to 0.5 m
  EXPECT_THAT(test::refusal([&] { SimRunner(config_in(folder, box, "{x_m: 0, z_m: 0}")); }),
              AllOf(HasSubstr("vehicle 'a', obstacle 'm/c': the vehicle starts inside it"),
                    HasSubstr("the uppermost surface there is at z_m 0.50")));
  EXPECT_NO_THROW(SimRunner(config_in(folder, box, "{x_m: 0, z_m: 0.49}")));
  EXPECT_NO_THROW(SimRunner(config_in(folder, kAsphalt + box, "{x_m: 3, z_m: 0.1}")));
}

TEST(SdfWorld, AStartWithoutAHeightStandsOnTheUppermostSurface) {
  const cas::test::TemporaryFolder folder;
  const auto lowest = [&](const std::string& elements, std::optional<double> z_m, double x_m = 0) {
    SimConfig config = config_in(folder, elements, "{x_m: 0, z_m: 0}");
    config.vehicles[0].pose = {.x_m = x_m, .z_m = z_m};
    const double at_zero =
        start_state(load_vehicle_model(config.vehicles[0].vehicle.urdf), {}).p_WB.z();
    SimRunner runner(config);
    return runner.world().state(VehicleId{0}).p_WB.z() - at_zero;
  };
  const std::string box = obstacle("<friction/>");  // from -0.5 to 0.5 m
  EXPECT_NEAR(lowest(box, std::nullopt), 0.5, 1e-9);
  EXPECT_NEAR(lowest(kAsphalt, std::nullopt), 0.05, 1e-9);
  EXPECT_NEAR(lowest(kAsphalt + box, std::nullopt), 0.5, 1e-9);
  EXPECT_NEAR(lowest(kAsphalt + box, std::nullopt, 0.55), 0.5, 1e-9) << "half on the box";
  EXPECT_NEAR(lowest(kAsphalt + box, std::nullopt, 5), 0.05, 1e-9);
  EXPECT_THAT(test::refusal([&] { lowest(box, std::nullopt, 5); }),
              HasSubstr("has no ground below the start of vehicle 'a'"));
  EXPECT_EQ(lowest(box, 3.0), 3);
}

TEST(SdfWorld, AStartInsideAClosedMeshIsRefusedToo) {
  const cas::test::TemporaryFolder folder;
  folder.write("cube.obj",
               "v -9 -9 -9\nv 9 -9 -9\nv 9 9 -9\nv -9 9 -9\nv -9 -9 9\nv 9 -9 9\nv 9 9 9\n"
               "v -9 9 9\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const std::string cube =
      "<model name='m'><static>1</static><link name='l'><collision name='c'><geometry><mesh><uri>"
      "cube.obj</uri></mesh></geometry></collision></link></model>";
  EXPECT_THAT(test::refusal([&] { SimRunner(config_in(folder, cube, "{x_m: 0, z_m: 0}")); }),
              HasSubstr("obstacle 'm/c'"));
  EXPECT_NO_THROW(SimRunner(config_in(folder, kAsphalt + cube, "{x_m: 20, z_m: 0.1}")));
}

TEST(SdfWorld, AVehicleBelowEverythingEndsTheRunWithTimeAndPlace) {
  const cas::test::TemporaryFolder folder;
  SimRunner runner(config_in(folder, obstacle("<friction/>"), "{x_m: 0.6, z_m: 0.51}"));  // tips
  runner.start();
  const std::string refusal = test::refusal([&] {
    for (int i = 0; i < 5000; ++i) runner.step();
  });
  EXPECT_THAT(refusal, AllOf(HasSubstr("vehicle 'a' has fallen out of the world: at "),
                             HasSubstr("s it is at x "), HasSubstr(", z -")));
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
  const std::string world = "missing: ignore\nworld: " + (kData / "classic.world").string() + "\n";
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
