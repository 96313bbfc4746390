// SPDX-License-Identifier: BSD-3-Clause
// Numbers, values and sizes of a world that are refused or told.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "libsim/core/load/world_loader.hpp"
#include "tests/libsim/support/sdf_elements.hpp"
#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using test::load_elements;
using test::world_of;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

/// A static model with this in its collision.
std::string solid(const std::string& geometry, const std::string& more = "") {
  return "<model name='m'><static>1</static><link name='l'><collision name='c'>\n<geometry>" +
         geometry + "</geometry>" + more + "</collision></link></model>";
}

std::string ode(const std::string& friction, const std::string& contact) {
  return "<surface><friction><ode>" + friction + "</ode></friction><contact><ode>" + contact +
         "</ode></contact></surface>";
}

const std::string kBox = "<box><size>1 1 1</size></box>";

const std::string kPlace =
    "<spherical_coordinates><surface_model>EARTH_WGS84</surface_model><latitude_deg>";

TEST(FaultyWorlds, AreRefusedWithLineAndElement) {
  struct FaultyWorld {
    const char* name;
    std::string elements;
    const char* sentence;  ///< with its line
  };
  const FaultyWorld rows[] = {
      {"CommaInGravity", "<gravity>0 0 -9,8</gravity>",
       "w.sdf:3: <gravity>: '-9,8' is no number (decimals follow a point"},
      {"CommaInARadius", solid("<sphere><radius>0,5</radius></sphere>"),
       "w.sdf:4: <radius>: '0,5' is no number"},
      {"UnitBehindARadius", solid("<sphere><radius>0.5m</radius></sphere>"),
       "w.sdf:4: <radius>: '0.5m' is no number"},
      {"CommaInASize", solid("<box><size>4 4 1,5</size></box>"),
       "w.sdf:4: <size>: '1,5' is no number"},
      {"OneNumberTooMany", solid("<box><size>4 4 1 5</size></box>"),
       "w.sdf:4: <size> has 4 numbers instead of 3"},
      {"CommaInAPose", solid(kBox, "<pose>0 0 0 0 0 1,57</pose>"),
       "w.sdf:4: <pose>: '1,57' is no number"},
      {"CommaInAFriction", solid(kBox, ode("<mu>0,5</mu>", "")),
       "w.sdf:4: <mu>: '0,5' is no number"},
      {"LetterInABitmask",
       solid(kBox, "<surface><contact><collide_bitmask>1x</collide_bitmask></contact></surface>"),
       "w.sdf:4: <collide_bitmask>: '1x' is no number"},
      {"CommaInAMeshScale", solid("<mesh><uri>m.stl</uri><scale>1 1 0,001</scale></mesh>"),
       "w.sdf:4: <scale>: '0,001' is no number"},
      {"CommaInANormal", solid("<plane><normal>0 0,1 1</normal></plane>"),
       "w.sdf: holds no SDF world: line 4: Error reading element <normal>"},
      {"CommaInAHeightmap", solid("<heightmap><uri>m.png</uri><size>9 9 1,5</size></heightmap>"),
       "w.sdf:4: <size>: '1,5' is no number"},
      {"CommaInAStep", "<physics type='ode'><max_step_size>0,001</max_step_size></physics>",
       "w.sdf:3: <max_step_size>: '0,001' is no number"},
      {"CommaInAWaypoint",
       "<actor name='a'><script><trajectory id='0' type='t'><waypoint><time>0</time>"
       "<pose>0,5 0 0 0 0 0</pose></waypoint></trajectory></script></actor>",
       "w.sdf:3: <pose>: '0,5' is no number"},
      {"BoxOfZero", solid("<box><size>1 0 1</size></box>"),
       "w.sdf:3: collision 'm/c': the <size> of a <box> must lie above 0"},
      {"BoxBelowZero", solid("<box><size>1 1 -1</size></box>"), "the <size> of a <box>"},
      {"SphereOfZero", solid("<sphere><radius>0</radius></sphere>"), "the <radius>"},
      {"EndlessSphere", solid("<sphere><radius>inf</radius></sphere>"),
       "the <radius> must lie above 0 and below 1e8 m"},
      {"SphereOfNaN", solid("<sphere><radius>nan</radius></sphere>"), "'nan' is no number"},
      {"CylinderBelowZero", solid("<cylinder><radius>1</radius><length>-2</length></cylinder>"),
       "the <length>"},
      {"PlaneWithoutNormal", solid("<plane><normal>0 0 0</normal></plane>"),
       "the <normal> of a <plane> must have a length"},
      {"MeshOfScaleZero", solid("<mesh><uri>m.stl</uri><scale>1 1 0</scale></mesh>"),
       "the <scale> of a <mesh> must not be 0"},
      {"HeightmapBelowZero", solid("<heightmap><uri>m.png</uri><size>9 9 -1</size></heightmap>"),
       "a <heightmap> needs a <size>"},
      {"FarAway", solid(kBox, "<pose>1e9 0 0 0 0 0</pose>"), "more than 1e8 m away"},
      {"FrictionBelowZero", solid(kBox, ode("<mu>-1</mu>", "")),
       "w.sdf: holds no SDF world: line 4: Error reading element <mu>"},
      {"StiffnessOfZero", solid(kBox, ode("", "<kp>0</kp>")),
       "w.sdf:4: collision 'm/c': <kp> must be above 0"},
      {"DampingBelowZero", solid(kBox, ode("", "<kd>-1</kd>")), "<kd> must be above 0"},
      {"Gravity", "<gravity>0 0 -1000</gravity>", "<gravity> must lie within 100"},
      {"Wind", "<wind><linear_velocity>1e4 0 0</linear_velocity></wind>", "within 100 m/s"},
      {"LatitudeAndLongitudeSwapped",
       kPlace + "139.69</latitude_deg><longitude_deg>35.68</longitude_deg><elevation>4"
                "</elevation></spherical_coordinates>",
       "w.sdf:3: <spherical_coordinates>: <latitude_deg> must lie in [-90, 90]"},
      {"BelowTheSea",
       kPlace + "47</latitude_deg><longitude_deg>8</longitude_deg><elevation>-11000"
                "</elevation></spherical_coordinates>",
       "<elevation> in [-1000, 10000] m"},
      {"LatitudeOfNaN",
       kPlace + "nan</latitude_deg><longitude_deg>8</longitude_deg><elevation>0"
                "</elevation></spherical_coordinates>",
       "<latitude_deg>: 'nan' is no number"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_THAT(test::refusal([&] { load_elements(row.elements); }), HasSubstr(row.sentence));
  }
}

TEST(SdfWorld, ANumberThatNothingDependsOnIsNotRefused) {
  EXPECT_EQ(load_elements("<model name='m'><static>1</static><link name='l'><collision name='c'>"
                          "<geometry><box><size>1 1 1</size></box></geometry></collision><visual "
                          "name='v'><geometry><box><size>1 1 1,5</size></box></geometry></visual>"
                          "</link></model>")
                .statics.size(),
            1u);
}

TEST(SdfWorld, AStiffnessWithoutDampingIsTold) {
  const WorldModel model =
      load_elements(solid(kBox, ode("<mu>inf</mu>", "<kp>1e5</kp><kd>0</kd>")));
  EXPECT_THAT(model.warnings, Contains(HasSubstr("w.sdf:4: collision 'm/c': a <kd> of 0 is left")));
  EXPECT_EQ(model.statics.at(0).surface.damping_n_s_m, std::nullopt);
  EXPECT_TRUE(std::isinf(model.statics.at(0).surface.friction));
}

TEST(SdfWorld, LeavesOutARealTimeFactorThatCannotBe) {
  for (const char* factor : {"0", "-1", "1e9"}) {
    const WorldModel model =
        load_elements("<physics type='ode'><max_step_size>0.001</max_step_size><real_time_factor>" +
                      std::string(factor) + "</real_time_factor></physics>");
    EXPECT_FALSE(model.real_time_factor.has_value()) << factor;
    EXPECT_THAT(model.warnings, Contains(HasSubstr("w.sdf:3: <real_time_factor> must lie in")));
  }
}

TEST(SdfWorld, AVehicleAmongTheModelsIsTold) {
  const WorldModel model =
      load_elements("<model name='iris'><link name='l'><collision name='c'><geometry>" + kBox +
                    "</geometry></collision></link>\n<plugin name='p' "
                    "filename='libgazebo_motor_model.so'/></model>");
  EXPECT_THAT(
      model.warnings,
      Contains(HasSubstr(
          "w.sdf:4: model 'iris' is a vehicle (its <plugin> 'p' is libgazebo_motor_model.so)")));
}

TEST(SdfWorld, ASensorWithoutTheElementOfItsTypeIsRead) {
  for (const char* type : {"imu", "navsat", "camera", "gpu_lidar", "altimeter", "force_torque"}) {
    const std::string sensor = "<sensor name='s' type='" + std::string(type) + "'/>";
    const WorldModel model = load_elements("<model name='m'><static>1</static><link name='l'>" +
                                           sensor + "</link></model>");
    EXPECT_THAT(model.warnings, ElementsAre(HasSubstr("<sensor name='s'> is left out"))) << type;
  }
}

/// Each used to take two megabytes: 4.8 GB.
TEST(SdfWorld, ManyModelsOfAWorldsOwnFileTakeLittle) {
  constexpr std::size_t kModels = 2'000;
  std::string models;
  for (std::size_t i = 0; i < kModels; ++i) {
    std::string model = solid(kBox);
    models += model.replace(model.find("'m'"), 3, "'m" + std::to_string(i) + "'") + "\n";
  }
  const WorldModel world = load_elements(models);
  EXPECT_EQ(world.statics.size(), kModels);
  EXPECT_TRUE(world.warnings.empty());
}

TEST(SdfWorld, ElementsAreCountedBeforeTheyAreRead) {
  const cas::test::TemporaryFolder folder;
  const auto refuse = [&](const std::string& name, const std::string& text) {
    return test::refusal([&] { load_sdf_world(folder.write(name, text), {}); });
  };
  std::string deep = "<sdf version='1.6'><world name='w'>";
  for (int i = 0; i < 20'000; ++i) deep += "<model name='m'>";
  EXPECT_THAT(refuse("deep.sdf", deep), HasSubstr("deep.sdf: elements lie more than 200 deep"));

  std::string many = "<model name='o'>";
  for (int i = 0; i < 1'800; ++i) many += solid("<sphere><radius>1</radius></sphere>");
  EXPECT_THAT(refuse("many.sdf", world_of(many + "</model>")),
              HasSubstr("many.sdf: libsdformat takes about 4 GB for this world"));

  std::string twice;
  for (int i = 0; i < 12; ++i) twice += "<include><uri>ten.sdf</uri></include>";
  std::string ten = "<sdf version='1.6'><model name='m'>";
  for (int i = 0; i < 700; ++i) ten += "<link name='l" + std::to_string(i) + "'></link>";
  folder.write("ten.sdf", ten + "</model></sdf>");
  EXPECT_THAT(refuse("twice.sdf", world_of(twice)),
              HasSubstr("twice.sdf: libsdformat takes about 7 GB for this world"));

  const std::string itself =
      "<sdf version='1.6'><model name='m'><include><uri>own.sdf</uri></include></model></sdf>";
  folder.write("own.sdf", itself);
  EXPECT_THAT(refuse("w.sdf", world_of("<include><uri>own.sdf</uri></include>")),
              HasSubstr("own.sdf: the model includes itself"));
}

}  // namespace
}  // namespace cas::sim
