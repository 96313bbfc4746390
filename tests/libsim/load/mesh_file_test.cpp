// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/mesh_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "libsim/core/body/shape.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using testing::HasSubstr;

class MeshFile : public testing::Test {
 protected:
  cas::test::TemporaryFolder folder_;
};

TEST_F(MeshFile, ReadsTextStl) {
  const auto file = folder_.write("a.stl",
                                  "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                                  "vertex 1 0 0\nvertex 0 2e0 3\nendloop\nendfacet\nendsolid a\n");
  const TriangleMesh mesh = load_mesh(file, {1, 2, 1});
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(0, 4, 3));
}

TEST_F(MeshFile, ReadsObjFacesOfAnyLength) {
  const auto file = folder_.write("a.OBJ",
                                  "\xef\xbb\xbfv 0 0 0\n# square\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 "
                                  "0 1\nf 1//1 2//1 3//1 -1//1\n");
  const TriangleMesh mesh = load_mesh(file);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
}

/// A unit square in the file's x-y plane as `faces`, in a scene that moves it by 10 units along x.
std::string collada(const std::string& asset, const std::string& faces) {
  return "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema'>"
         "<asset>" +
         asset +
         "</asset><library_geometries><geometry id='g'><mesh>"
         "<source id='p'><float_array id='a' count='12'>0 0 0  1 0 0  1 1 0\n 0 1 0</float_array>"
         "<technique_common><accessor source='#a' count='4' "
         "stride='3'/></technique_common></source>"
         "<vertices id='v'><input semantic='POSITION' source='#p'/></vertices>" +
         faces +
         "</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='s'>"
         "<node><translate>10 0 0</translate><node><matrix>1 0 0 0 0 1 0 0 0 0 1 2 0 0 0 1</matrix>"
         "<instance_geometry url='#g'/></node></node></visual_scene></library_visual_scenes>"
         "<scene><instance_visual_scene url='#s'/></scene></COLLADA>";
}

const std::string kTriangles =
    "<triangles count='2'><input semantic='VERTEX' source='#v' offset='0'/>"
    "<input semantic='NORMAL' source='#n' offset='1'/><p>0 0 1 0 2 0 0 0 2 0 3 0</p></triangles>";

TEST_F(MeshFile, ReadsColladaScenesWithTheirNodes) {
  const TriangleMesh mesh =
      load_mesh(folder_.write("a.dae", collada("<up_axis>Z_UP</up_axis>", kTriangles)));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_LT((mesh.vertices[2] - Eigen::Vector3d(11, 1, 2)).norm(), 1e-12);
}

TEST_F(MeshFile, AppliesColladaUnitAndUpAxis) {
  const TriangleMesh mesh = load_mesh(
      folder_.write("a.dae", collada("<unit meter='0.1'/><up_axis>Y_UP</up_axis>", kTriangles)));
  EXPECT_LT((mesh.vertices[2] - Eigen::Vector3d(1.1, -0.2, 0.1)).norm(), 1e-12) << "its y is up";
}

TEST_F(MeshFile, ReadsColladaPolylists) {
  const TriangleMesh mesh = load_mesh(folder_.write(
      "a.dae", collada("<up_axis>Z_UP</up_axis>",
                       "<polylist count='1'><input semantic='VERTEX' source='#v' offset='0'/>"
                       "<vcount>4</vcount><p>0 1 2 3</p></polylist>")));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
}

TEST_F(MeshFile, RefusesDamageAndOtherFormats) {
  const auto refuse = [&](const std::string& name, const std::string& text) {
    return test::refusal([&] { load_mesh(folder_.write(name, text)); });
  };
  EXPECT_THAT(refuse("a.fbx", "FBX"), HasSubstr("a.fbx: mesh format is not supported"));
  EXPECT_THAT(refuse("a.dae", "<COLLADA/>"), HasSubstr("a.dae: mesh has no triangle"));
  EXPECT_THAT(refuse("b.dae", "<COLLADA>\n<scene"), HasSubstr("b.dae:2: "));
  EXPECT_THAT(refuse("c.dae", "<svg/>"), HasSubstr("c.dae: is no COLLADA file"));
  EXPECT_THAT(
      refuse("d.dae", "<COLLADA><scene><instance_visual_scene url='#x'/></scene></COLLADA>"),
      HasSubstr("d.dae: names 'x'"));
  EXPECT_THAT(refuse("a.stl", "solid a\nendsolid\n"), HasSubstr("mesh has no triangle"));
  EXPECT_THAT(refuse("b.stl", "solid\nvertex 1 2\n"), HasSubstr("neither binary nor text STL"));
  EXPECT_THAT(refuse("a.obj", "v 0 0 0\nf 1 2 3\n"), HasSubstr("face names no vertex: 2"));
  EXPECT_THAT(test::refusal([] { load_mesh("/nowhere.stl"); }), HasSubstr("cannot be read"));
}

TEST(Shape, LowestPointFollowsTheAttitude) {
  const Eigen::Matrix3d rolled =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  Shape shape;
  shape.geometry = Box{{2, 4, 6}};
  EXPECT_NEAR(lowest_point(shape, Eigen::Matrix3d::Identity()), -3, 1e-12);
  EXPECT_NEAR(lowest_point(shape, rolled), -2, 1e-12);
  shape.geometry = Cylinder{0.5, 2};
  shape.pose.translation() = Eigen::Vector3d(0, 1, 0);
  EXPECT_NEAR(lowest_point(shape, Eigen::Matrix3d::Identity()), -1, 1e-12);
  EXPECT_NEAR(lowest_point(shape, rolled), 0.5, 1e-12);
  shape.geometry = Sphere{0.25};
  EXPECT_NEAR(lowest_point(shape, rolled), 0.75, 1e-12);
  EXPECT_NEAR(bounding_radius(shape), 1.25, 1e-12);
}

}  // namespace
}  // namespace cas::sim
