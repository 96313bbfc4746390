// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/model_loader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/config/model_body.hpp"
#include "base/config/vehicle.hpp"
#include "base/error.hpp"
#include "libsim/core/load/visuals.hpp"
#include "libsim/core/load/world_loader.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string link(const std::string& name, const std::string& inside) {
  return "<link name='" + name + "'>" + inside + "</link>\n";
}
std::string inertial(double mass, const std::string& xyz, const std::string& rpy,
                     const std::string& inertia) {
  return "<inertial><origin xyz='" + xyz + "' rpy='" + rpy + "'/><mass value='" +
         std::to_string(mass) + "'/><inertia " + inertia + "/></inertial>";
}
std::string joint(const std::string& type, const std::string& child, const std::string& xyz,
                  const std::string& rpy = "0 0 0") {
  return "<joint name='" + child + "_joint' type='" + type + "'><origin xyz='" + xyz + "' rpy='" +
         rpy + "'/><parent link='base'/><child link='" + child +
         "'/><axis xyz='0 0 1'/><limit effort='1' velocity='1' lower='0' upper='1'/></joint>\n";
}
const std::string kBall = "ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'";
const std::string kCollision =
    "<collision><geometry><box size='0.4 0.4 0.1'/></geometry></collision>";

class ModelLoader : public testing::Test {
 protected:
  VehicleModel load(const std::string& inside) {
    return load_vehicle_model(folder_.write("v.urdf", "<robot name='v'>" + inside + "</robot>"));
  }
  std::string refuse(const std::string& inside) {
    return test::refusal([&] { load(inside); });
  }
  cas::test::TemporaryFolder folder_;
};

TEST_F(ModelLoader, ShippedVehiclesAgreeWithTheirFiles) {
  for (const char* name : {"iris_paper", "iris_px4"}) {
    const auto vehicle =
        base::Vehicle::load(test::kSourceDir / "config/vehicles" / (std::string(name) + ".yaml"));
    const VehicleModel model = load_vehicle_model(vehicle.urdf);
    EXPECT_THAT(model.warnings, IsEmpty());
    EXPECT_NEAR(model.mass.mass_kg(), vehicle.mass_kg, 1e-9);
    EXPECT_LT((model.mass.inertia_B().diagonal() - vehicle.inertia_kg_m2).norm(), 1e-8);
    ASSERT_EQ(model.rotors.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LT((model.rotors[i].position_B_m - vehicle.rotors[i].position_B_m).norm(), 1e-8);
      EXPECT_LT((model.rotors[i].axis_B - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
    }
  }
}

TEST_F(ModelLoader, CombinesLinksByTheParallelAxisTheorem) {
  // Two balls of 1 kg, 1 m apart: a dumbbell. Centre in the middle; across: 2 (0.01 + 1 * 0.5^2).
  const VehicleModel model =
      load(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision) +
           link("tip", inertial(1, "0 0 0", "0 0 0", kBall)) + joint("fixed", "tip", "1 0 0"));
  EXPECT_NEAR(model.mass.mass_kg(), 2, 1e-12);
  EXPECT_LT((model.cog_in_root_m - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-12);
  EXPECT_LT((model.mass.inertia_B().diagonal() - Eigen::Vector3d(0.02, 0.52, 0.52)).norm(), 1e-12);
  EXPECT_NEAR(model.shapes[0].pose.translation().x(), -0.5, 1e-12);
}

TEST_F(ModelLoader, TurnsInertiasIntoTheRootsAxes) {
  // A rod along its own x, mounted along y of the root.
  const std::string rod = "ixx='0.001' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'";
  const VehicleModel model =
      load(link("base", inertial(1e-9, "0 0 0", "0 0 0",
                                 "ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'") +
                            kCollision) +
           link("rod", inertial(1, "0 0 0", "0 0 1.5707963267948966", rod)) +
           joint("fixed", "rod", "0 0 0"));
  EXPECT_LT((model.mass.inertia_B().diagonal() - Eigen::Vector3d(0.1, 0.001, 0.1)).norm(), 1e-8);
}

TEST_F(ModelLoader, TakesWhatXacroMadeWithItsCommentsInIt) {
  const VehicleModel model = load("<!-- <xacro:include filename='rotor.xacro'/> {% old %} -->" +
                                  link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision));
  EXPECT_NEAR(model.mass.mass_kg(), 1, 1e-12);
}

TEST_F(ModelLoader, ContinuousJointsAreRotors) {
  const VehicleModel model = load(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision) +
                                  link("prop", inertial(0.01, "0 0 0", "0 0 0", kBall)) +
                                  joint("continuous", "prop", "0.2 0.1 0.05", "0.1 0 0"));
  ASSERT_EQ(model.rotors.size(), 1u);
  EXPECT_EQ(model.rotors[0].joint, "prop_joint");
  EXPECT_NEAR(model.rotors[0].axis_B.y(), -std::sin(0.1), 1e-12);
  EXPECT_NEAR(model.rotors[0].position_B_m.x(), 0.2 - 0.002 / 1.01, 1e-12);
}

TEST_F(ModelLoader, NamesInertiasThatNoBodyHas) {
  // The figures of [HILS] Fig. 4: i_yy of 1e-22 beside i_xy of 5e-7.
  const std::string absurd =
      "ixx='1.61247820352629E-06' ixy='5.61993810631176E-07' ixz='3.10511981052143E-24' "
      "iyy='1.28805193648675E-22' iyz='-3.65987310616101E-06' izz='2.22548464616382E-22'";
  const VehicleModel model =
      load(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision) +
           link("prop", inertial(0.002477, "0.025982 0 0.061733", "0 0 0", absurd)) +
           joint("fixed", "prop", "0 0 0"));
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_THAT(model.warnings[0], HasSubstr("link 'prop': no body has this <inertia>"));
  EXPECT_TRUE(base::is_physical_inertia(model.mass.inertia_B()));
}

TEST_F(ModelLoader, LeavesTheInertiaOfALinkWithoutMassOut) {
  const VehicleModel model =
      load(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision) +
           link("frame", inertial(0, "0 0 0", "0 0 0", kBall)) + joint("fixed", "frame", "0 0 0"));
  const VehicleModel alone = load(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision));
  EXPECT_EQ(model.mass.inertia_B(), alone.mass.inertia_B());
  EXPECT_THAT(model.warnings, ElementsAre(HasSubstr("link 'frame': no body without mass has an")));
}

TEST_F(ModelLoader, ReadsASolidWorksExport) {
  // NAME/urdf and NAME/meshes, package:// URIs, links joined rigidly.
  std::string stl(80, ' ');
  const auto add = [&stl](const auto& value) {
    stl.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  add(std::uint32_t{2});
  const float corners[2][9] = {{-1, -2, 0, 1, -2, 0, 1, 2, 0.5F},
                               {-1, -2, 0, 1, 2, 0.5F, -1, 2, 0}};
  for (const auto& corner : corners) {
    for (int i = 0; i < 3; ++i) add(0.0F);
    for (const float value : corner) add(value);
    add(std::uint16_t{0});
  }
  folder_.write("UAV/meshes/Quad.STL", stl);
  const auto file = folder_.write(
      "UAV/urdf/UAV.urdf",
      "<robot name='UAV'>" +
          link("base_link",
               inertial(1.5, "0 0 0", "0 0 0", kBall) +
                   "<collision><origin xyz='0 0 0' rpy='1.5707963267949 0 0'/><geometry><mesh "
                   "filename='package://UAV/meshes/Quad.STL' scale='0.1 0.1 0.1'/></geometry>"
                   "</collision>") +
          "</robot>");
  const VehicleModel model = load_vehicle_model(file);
  const Box& box = std::get<Box>(model.shapes.at(0).geometry);
  EXPECT_LT((box.size_m - Eigen::Vector3d(0.2, 0.4, 0.05)).norm(), 1e-7);
  EXPECT_NEAR(model.shapes[0].pose.translation().y(), -0.025, 1e-7);
}

constexpr const char* kTriangle =
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nendsolid s\n";

std::string visual(const std::string& geometry) {
  return "<visual><origin xyz='0 0 0.5'/><geometry>" + geometry + "</geometry></visual>";
}

TEST_F(ModelLoader, AVehicleIsDrawnByItsMeshesWithoutItsRotors) {
  folder_.write("frame.stl", kTriangle);
  const std::string box = visual("<box size='0.1 0.2 0.3'/>");
  const std::string mesh = visual("<mesh filename='frame.stl' scale='0.1 0.1 0.1'/>");
  const VehicleModel model = load(
      link("base", inertial(1, "0 0 0.2", "0 0 0", kBall) + kCollision + mesh + box +
                       visual("<mesh filename='nowhere.stl'/>") + visual("<sphere radius='0'/>")) +
      link("prop", visual("<box size='1 1 1'/>")) + joint("continuous", "prop", "0.2 0.2 0"));
  EXPECT_THAT(
      model.warnings,
      ElementsAre(
          HasSubstr("link 'base': this <visual> is left out: mesh 'nowhere.stl' is nowhere"),
          HasSubstr("v.urdf:1: link 'base': this <visual> is left out: it has a size")));
  std::vector<std::string> warnings;
  const std::vector<Shape> shapes = load_visuals(model, false, 1, warnings);
  ASSERT_EQ(shapes.size(), 2U);
  const Mesh& drawn = std::get<Mesh>(shapes[0].geometry);
  EXPECT_TRUE(drawn.triangles->vertices.at(1).isApprox(Eigen::Vector3d(0.1, 0, 0), 1e-6));
  EXPECT_NEAR(shapes[0].pose.translation().z(), 0.3, 1e-9) << "about the centre of gravity";
  EXPECT_TRUE(std::get<Box>(shapes[1].geometry).size_m.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_THAT(load_visuals(model, false, 0, warnings), IsEmpty()) << "too many triangles";
  EXPECT_THAT(warnings, IsEmpty());

  folder_.write("frame.stl", "no mesh");
  EXPECT_THAT(load_visuals(model, false, 1, warnings), IsEmpty()) << "a stand-in is drawn";
  EXPECT_THAT(warnings, ElementsAre(AllOf(HasSubstr("frame.stl: "), HasSubstr("link 'base'"))));
  const VehicleModel plain =
      load(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision + box));
  EXPECT_THAT(load_visuals(plain, false, 1, warnings), IsEmpty()) << "as the stand-in";
}

TEST_F(ModelLoader, AVisualThatCannotBeReadCostsItselfAlone) {
  folder_.write("frame.stl", kTriangle);
  folder_.write("cut.stl", "solid s\nfacet");
  folder_.write("body.gltf", "{}");
  const VehicleModel model = load(
      link("base", inertial(1, "0 0 0", "0 0 0", kBall) + visual("<mesh filename='body.gltf'/>") +
                       visual("<box size='1 1,5 1'/>") + visual("<mesh filename='cut.stl'/>") +
                       visual("<mesh filename='frame.stl'/>") + "<visual/>" + kCollision));
  EXPECT_EQ(model.shapes.size(), 1U) << "the collision stays";
  EXPECT_THAT(model.warnings,
              ElementsAre(HasSubstr("'1,5' is no number"),
                          HasSubstr("v.urdf:1: <visual> has no <geometry>; link 'base' is drawn"),
                          HasSubstr("body.gltf: mesh format is not supported")));
  std::vector<std::string> warnings;
  EXPECT_EQ(load_visuals(model, false, 1, warnings).size(), 1U);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("cut.stl:2: the STL file is cut")));
  EXPECT_THAT(refuse(link("base", inertial(1, "0 0 0", "0 0 0", kBall) +
                                      "<collision><geometry><mesh filename='cut.stl'/></geometry>"
                                      "</collision>")),
              HasSubstr("cut.stl:2: the STL file is cut"))
      << "of a collision it is an error";
}

TEST_F(ModelLoader, WhatIsSaidAboutAMeshNamesItsLink) {
  folder_.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 9 9 9\nf 1 2 3\n");
  const auto base_of = [](const std::string& mesh) {
    return link("base", inertial(1, "0 0 0", "0 0 0", kBall) + "<collision><geometry>\n<mesh " +
                            mesh + "/></geometry></collision>");
  };
  const VehicleModel model = load(base_of("filename='m.obj'"));
  EXPECT_THAT(model.warnings,
              ElementsAre(AllOf(HasSubstr("m.obj:5: vertices of no face are left out: 1"),
                                HasSubstr("; it is a <collision> of link 'base', "),
                                HasSubstr("v.urdf:2"))));
  EXPECT_EQ(std::get<Box>(model.shapes.at(0).geometry).size_m.y(), 2) << "without that vertex";
  EXPECT_THAT(refuse(base_of("filename='m.obj' scale='1 0 1'")),
              AllOf(HasSubstr("m.obj: a mesh cannot be scaled by 0; it is a <collision> of link"),
                    HasSubstr("v.urdf:2")));
}

TEST_F(ModelLoader, AnSdfModelIsDrawnByItsMeshes) {
  folder_.write("frame.stl", kTriangle);
  const auto model_with = [&](const std::string& visual) {
    return load_vehicle_model(folder_.write(
        "v.sdf",
        "<sdf version='1.9'><model name='m'><link name='base'><inertial><mass>1</mass><inertia>"
        "<ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>"
        "<collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>"
        "<visual name='v'><geometry>" +
            visual + "</geometry></visual></link></model></sdf>"));
  };
  const VehicleModel model = model_with("<mesh><uri>frame.stl</uri><scale>2 2 2</scale></mesh>");
  std::vector<std::string> warnings;
  const std::vector<Shape> shapes = load_visuals(model, false, 1, warnings);
  ASSERT_EQ(shapes.size(), 1U);
  EXPECT_EQ(std::get<Mesh>(shapes[0].geometry).triangles->vertices.at(1).x(), 2);
  const VehicleModel undrawn = model_with("<box><size>wide</size></box>");
  EXPECT_THAT(undrawn.visuals, IsEmpty());
  EXPECT_THAT(undrawn.warnings, ElementsAre(HasSubstr("'wide' is no number")));
}

TEST_F(ModelLoader, OtherMovingJointsAreTakenAsFixed) {
  const VehicleModel model =
      load(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + kCollision) +
           link("arm", inertial(0.1, "0 0 0", "0 0 0", kBall)) + joint("revolute", "arm", "0 0 0"));
  EXPECT_THAT(model.warnings, Contains(HasSubstr("joint 'arm_joint' moves")));
}

/// Poses upon poses; libsdformat, which reads worlds here, resolves them by its own code.
const std::string kSdf = R"(<model name='leaning'>
  <frame name='arm' attached_to='body'><pose>0.2 0 0.05 0 0 0.5</pose></frame>
  <link name='body'>
    <pose>0.01 0 0.02 0.1 0 0.2</pose>
    <inertial>
      <pose>0.02 0 0 0 0 0</pose><mass>1.2</mass>
      <inertia><ixx>0.01</ixx><iyy>0.012</iyy><izz>0.02</izz><ixz>0.001</ixz></inertia>
    </inertial>
    <collision name='box'>
      <pose>0 0 -0.02 0 0.2 0</pose><geometry><box><size>0.2 0.3 0.1</size></box></geometry>
    </collision>
    <collision name='mast'>
      <pose relative_to='arm'>0 0 0.1 0 0 0</pose>
      <geometry><cylinder><radius>0.02</radius><length>0.2</length></cylinder></geometry>
    </collision>
  </link>
  <link name='prop'>
    <pose relative_to='arm'>0.1 0 0.03 0.3 0 0</pose>
    <inertial>
      <mass>0.02</mass><inertia><ixx>2e-5</ixx><iyy>2e-5</iyy><izz>4e-5</izz></inertia>
    </inertial>
  </link>
  <joint name='motor' type='revolute'>
    <pose>0 0 0.01 0 0.2 0</pose><parent>body</parent><child>prop</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis>
  </joint>
  <link name='foot'>
    <pose relative_to='motor' degrees='true'>0 0 -0.3 0 45 0</pose>
    <inertial>
      <mass>0.1</mass><inertia><ixx>1e-4</ixx><iyy>1e-4</iyy><izz>1e-4</izz></inertia>
    </inertial>
    <collision name='ball'><geometry><sphere><radius>0.03</radius></sphere></geometry></collision>
  </link>
  <joint name='leg' type='fixed'><parent>body</parent><child>foot</child></joint>
</model>)";

TEST_F(ModelLoader, AnSdfModelStandsWhereLibsdformatHasIt) {
  const VehicleModel model =
      load_vehicle_model(folder_.write("v.sdf", "<sdf version='1.9'>" + kSdf + "</sdf>"));
  const WorldModel world = load_sdf_world(
      folder_.write("w.sdf", "<sdf version='1.9'><world name='w'>" + kSdf + "</world></sdf>"), {});
  constexpr double kRounding = 1e-9;  // libsdformat's pi for degrees, and its quaternions
  ASSERT_EQ(model.shapes.size(), 3U);
  ASSERT_EQ(world.statics.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    Eigen::Isometry3d X_RS = model.shapes[i].pose;
    X_RS.pretranslate(model.cog_in_root_m);
    EXPECT_TRUE(X_RS.isApprox(world.statics[i].pose, kRounding)) << world.statics[i].name;
    EXPECT_EQ(model.shapes[i].geometry.index(), world.statics[i].geometry.index());
  }
  // The propeller turns about the axis of its joint, which leans with arm, link and joint.
  const auto turn = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond body = turn(0.2, z) * turn(0.1, x);
  const Eigen::Quaterniond prop = body * turn(0.5, z) * turn(0.3, x);
  ASSERT_EQ(model.rotors.size(), 1U);
  EXPECT_TRUE(model.rotors[0].axis_B.isApprox(prop * turn(0.2, y) * z, kRounding));
  const Eigen::Vector3d arm = Eigen::Vector3d(0.01, 0, 0.02) + body * Eigen::Vector3d(0.2, 0, 0.05);
  const Eigen::Vector3d hub = arm + body * turn(0.5, z) * Eigen::Vector3d(0.1, 0, 0.03) +
                              prop * Eigen::Vector3d(0, 0, 0.01);
  EXPECT_TRUE((model.rotors[0].position_B_m + model.cog_in_root_m).isApprox(hub, kRounding));
  EXPECT_NEAR(model.mass.mass_kg(), 1.32, kRounding);
}

TEST_F(ModelLoader, RefusesWhatCannotFly) {
  EXPECT_THAT(refuse(link("base", kCollision)), HasSubstr("no link has an <inertial>"));
  EXPECT_THAT(refuse(link("base", inertial(1, "0 0 0", "0 0 0", kBall))),
              HasSubstr("has no <collision>"));
  EXPECT_THAT(refuse(link("base", inertial(1, "0 0 0", "0 0 0", kBall) +
                                      "<collision><geometry><capsule radius='1' length='1'/>"
                                      "</geometry></collision>")),
              AllOf(HasSubstr("has no <collision>"), HasSubstr("; "),
                    HasSubstr("v.urdf:1: link 'base': a <capsule> collision is left out")));
  EXPECT_THAT(refuse("<link name="), HasSubstr("v.urdf:1: "));
  EXPECT_THAT(refuse("<robot name='r'>\n<link>\n</robot>"), HasSubstr("v.urdf:3: mismatched tag"));
  EXPECT_THAT(refuse("<robot name='r'/>"), HasSubstr("v.urdf:1: <robot> has no <link>"));
  const auto sdf = folder_.write("v.sdf", "<sdf version='1.6'/>");
  EXPECT_THAT(test::refusal([&] { load_vehicle_model(sdf); }),
              HasSubstr("v.sdf:1: has no <model>; a world is no vehicle"));
  EXPECT_THAT(refuse("<robot name='r'><xacro:rotor n='1'/></robot>"),
              HasSubstr("it is a xacro file, a template; expand it first"));
  EXPECT_THAT(
      refuse(link("base", inertial(1, "0 0 0", "0 0 0", kBall) +
                              "<collision><geometry><mesh filename='package://a/b.stl'/>"
                              "</geometry></collision>")),
      HasSubstr("link 'base': mesh 'package://a/b.stl' is nowhere to be found; looked for it at "));
  EXPECT_THAT(refuse(link("base", inertial(1, "0 0 0", "0 0 0", kBall) +
                                      "<collision><geometry><box size='1 0 1'/></geometry>"
                                      "</collision>")),
              HasSubstr("link 'base': a <collision> geometry has a size that is not above 0"));
  for (const std::string far : {"<box size='1 1 3000'/>", "<sphere radius='1e300'/>"}) {
    EXPECT_THAT(refuse(link("base", inertial(1, "0 0 0", "0 0 0", kBall) + "<collision><geometry>" +
                                        far + "</geometry></collision>")),
                AllOf(HasSubstr("v.urdf:1: link 'base': a <collision> reaches "),
                      HasSubstr(", and at most 1000 m can touch the ground; lengths are in m")));
  }
  const std::string flat = "ixx='1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'";
  EXPECT_THAT(refuse(link("base", inertial(1, "0 0 0", "0 0 0", flat) + kCollision)),
              HasSubstr("not that of a body"));
  EXPECT_THAT(test::refusal([] { load_vehicle_model("/nowhere.urdf"); }),
              HasSubstr("/nowhere.urdf: there is no such file; key 'urdf'"));
}

}  // namespace
}  // namespace cas::sim
