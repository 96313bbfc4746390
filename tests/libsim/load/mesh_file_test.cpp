// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/mesh_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/text.hpp"
#include "libsim/core/body/shape.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

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

TEST_F(MeshFile, LeavesOutTrianglesThatRepeatOthers) {
  // The square's halves, one of them again from another corner, and its other side.
  const auto file = folder_.write("a.obj",
                                  "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 1 0\n"
                                  "f 1 2 3\nf 1 3 4\nf 5 1 2\nf 3 2 1\n");
  std::vector<std::string> warnings;
  const TriangleMesh mesh =
      load_mesh(file, Eigen::Vector3d::Ones(), {.up_axis = {}, .warnings = &warnings});
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[2], (std::array<std::uint32_t, 3>{2, 1, 0}));
  EXPECT_THAT(
      warnings,
      ElementsAre(HasSubstr("a.obj: triangles left out that repeat others corner for corner: 1")));
}

TEST_F(MeshFile, RefusesDamageAndOtherFormats) {
  const auto refuse = [&](const std::string& name, const std::string& text) {
    return test::refusal([&] { load_mesh(folder_.write(name, text)); });
  };
  EXPECT_THAT(mesh_kind_refusal("a.gltf").value_or(""), HasSubstr("convert it to STL, OBJ or"));
  EXPECT_EQ(mesh_kind_refusal("a.DAE"), std::nullopt);
  EXPECT_THAT(refuse("a.fbx", "FBX"), HasSubstr("a.fbx: mesh format is not supported"));
  EXPECT_THAT(refuse("a.stl", "solid a\nendsolid\n"), HasSubstr("mesh has no triangle"));
  EXPECT_THAT(refuse("a.obj", "v 0 0 0\nf 1 2 3\n"), HasSubstr("a.obj:2: face names no vertex: 3"));
  EXPECT_THAT(test::refusal([] { load_mesh("/nowhere.stl"); }), HasSubstr("cannot be read"));
}

/// A square of 0.3 m in the x-y plane as binary STL.
std::string binary_stl(std::uint32_t promised, const std::string& header = "binary") {
  std::string bytes = header;
  bytes.resize(80, '\0');
  bytes.append(reinterpret_cast<const char*>(&promised), 4);
  for (const float shift : {0.0F, 0.3F}) {
    const std::array<float, 12> values{0, 0, 1, 0, 0, 0, 0.3F, 0, 0, shift, 0.3F, 0};
    bytes.append(reinterpret_cast<const char*>(values.data()), 48).append(2, '\0');
  }
  return bytes;
}

std::string text_stl(const std::string& corner = "0 1 0") {
  return "solid a part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex " +
         corner + "\nendloop\nendfacet\nendsolid a part\n";
}

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const std::string kCorner = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";

TEST(ForeignForms, AreRead) {
  struct Form {
    const char* name;
    const char* file;
    std::string bytes;
    std::size_t triangles;
    const char* warning = nullptr;  ///< part of the only one
  };
  const Form rows[] = {
      {"BinaryStlOfASolid", "a.stl", binary_stl(2, "solid base"), 2},
      {"BinaryStlWithBytesBehind", "a.stl", binary_stl(2) + std::string(7, '\0'), 2,
       "a.stl: its header promises 2 triangles, 184 bytes; it has 191 bytes: those behind"},
      {"BinaryStlOfASolidWithBytesBehind", "a.stl", binary_stl(2, "solid base") + "COLOR=abcd", 2,
       "those behind the triangles are left"},
      {"BinaryStlThatPromisesLess", "a.stl", binary_stl(1), 1, "it has 184 bytes"},
      {"TextStlInCapitals", "a.STL", base::upper(text_stl()), 1},
      {"TextStlWithMark", "a.stl", "\xef\xbb\xbf" + text_stl(), 1},
      {"TextStlWithoutSolid", "a.stl", text_stl().substr(13), 1},
      {"TextStlOfTwoSolids", "a.stl", text_stl() + text_stl(), 2},
      {"TextStlWithoutItsEnd", "a.stl", text_stl().substr(0, text_stl().find("endsolid")), 1,
       "a.stl:9: has no 'endsolid': the STL file may be cut here"},
      {"TextStlOfFourNumbers", "a.stl", text_stl("0 1 0 5"), 1,
       "a.stl:6: '5' is left out: of a facet three vertices of three numbers are read"},
      {"TextStlOfTwoNumbersANormal", "a.stl",
       "solid\nfacet normal 0 nan\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nendsolid\nCOLOR 1 1 1\n",
       1},
      {"ObjWithMark", "a.obj", "\xef\xbb\xbf" + kSquare + "f 1 2 3 4\n", 2},
      {"ObjContinuedLine", "a.obj", kSquare + "f 1 2 \\\n 3 \\\r\n4\n", 2},
      {"ObjCarriageReturns", "a.obj", "v 0 0 0\rv 1 0 0\rv 1 1 0\r# a\rf 1 2 \\\r3\r\rf 1 2 3\r",
       2},
      {"ObjBlanksBehindABackslash", "a.obj", kSquare + "f 1 2 \\ \t\n3 4\n", 2},
      {"ObjMissingNormals", "a.obj", kCorner + "f 1// 2/ 3/7\n", 1},
      {"ObjComments", "a.obj", "# v 0,5\n" + kSquare + "f 1 2 3 # below \\\nf 1 3 4#\n", 2},
      {"ObjVertexLater", "a.obj", "f 1 2 3\n" + kCorner, 1},
      {"ObjColoursAndWeights", "a.obj",
       "v 0 0 0 1 0.5 0\nv 1 0 0 1\nv 1 1 0 nan nan nan\nvt 0 0\nvn 0 0 1\nusemtl a,b\nf "
       "1/1/1 2/1 "
       "3//1\n",
       1},
      {"ObjLines", "a.obj", kSquare + "l 1 2\nf -4 -3 -2\n", 1},
      {"ObjThinFaces", "a.obj", kCorner + "f 1 2\nf 3\nf 1 2 3\n", 1,
       "a.obj:4: faces of fewer than three corners are left out"},
      {"ObjSurface", "a.obj", kSquare + "surf 0 1 0 1 1 2\nsurf 0 1\nf 1 2 3\n", 1,
       "a.obj:5: 'surf' is left out"},
      {"ObjCutWithinAFace", "a.obj", kSquare + "f 1 2 3 4\nf 4 3", 2,
       "a.obj:6: faces of fewer than three corners are left out; the file ends within this "
       "line: is it cut?"},
      {"ObjCutBehindAFace", "a.obj", kSquare + "v 0 0 1\nv 0 0 2\nf 1 2 3 4\n", 2,
       "a.obj:7: vertices of no face are left out: 2 (the first is vertex 5); is the file cut"}};
  for (const auto& form : rows) {
    SCOPED_TRACE(form.name);
    std::vector<std::string> warnings;
    const TriangleMesh mesh = parse_mesh(form.bytes, form.file, {.warnings = &warnings});
    EXPECT_EQ(mesh.triangles.size(), form.triangles);
    if (form.warning == nullptr) {
      EXPECT_THAT(warnings, IsEmpty());
    } else {
      EXPECT_THAT(warnings, ElementsAre(HasSubstr(form.warning)));
    }
  }
}

const float kNotFinite = std::numeric_limits<float>::quiet_NaN();

TEST(DamagedMesh, IsRefusedWithItsPlace) {
  struct Damage {
    const char* name;
    const char* file;
    std::string bytes;
    const char* sentence;
  };
  const Damage rows[] = {
      {"BinaryStlOfNoTriangles", "a.stl", binary_stl(0),
       "a.stl: no triangle is read of the STL file: its header promises 0 triangles, 84 "
       "bytes; it has 184"},
      {"CutBinaryStl", "a.stl", binary_stl(2).substr(0, 150),
       "a.stl: the STL file is cut: its header promises 2 triangles, 184 bytes; it has 150 "
       "bytes and ends within triangle 2"},
      {"BinaryStlOfTooFewTriangles", "a.stl", binary_stl(500), "promises 500 triangles"},
      {"BinaryStlHeaderAlone", "a.stl", "solid" + std::string(75, ' '), "the STL file is cut"},
      {"ShortBinaryStl", "a.stl", std::string(20, '\0'), "it has 20 bytes: is it cut?"},
      {"EmptyStl", "a.stl", "", "it has 0 bytes"},
      {"BinaryStlNotFinite", "a.stl",
       binary_stl(2).replace(84 + 12, 4, reinterpret_cast<const char*>(&kNotFinite), 4),
       "a.stl: triangle 1 has a corner that is not finite"},
      {"CutTextStl", "a.stl", text_stl().substr(0, 60),
       "a.stl:5: the STL file is cut: it ends within a facet"},
      {"CommaInTextStl", "a.stl", text_stl("0 0,5 0"), "a.stl:6: '0,5' is no number"},
      {"RestInTextStl", "a.stl", text_stl("0 1m 0"), "a.stl:6: '1m' is no number"},
      {"NanInTextStl", "a.stl", text_stl("0 nan 0"), "a.stl:6: 'nan' is no number"},
      {"TwoVerticesInTextStl", "a.stl",
       "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\nendsolid",
       "a.stl:5: a facet has three vertices, this one 2"},
      {"FourVerticesInTextStl", "a.stl", text_stl("0 1 0\nvertex 0 0 0"),
       "a.stl:7: a facet has three vertices, this one more"},
      {"Utf16", "a.obj", std::string("\xff\xfev\0 \0", 6),
       "a.obj: is text in UTF-16; save it as UTF-8"},
      {"PointerOfGitLfs", "a.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:0",
       "a.stl: is a pointer of Git LFS, not the mesh"},
      {"CommaInObj", "a.obj", "v 0 0,5 0\nf 1 1 1\n",
       "a.obj:1: '0,5' is no number (decimals follow a point, not a comma)"},
      {"TwoNumbersInObj", "a.obj", "\nv 0 0\n", "a.obj:2: a vertex has three numbers, this one 2"},
      {"ObjCutWithinAVertex", "a.obj", "v 0 0 0\nv 1 0",
       "a.obj:2: a vertex has three numbers, this one 2; the file ends within this line: "
       "is it cut?"},
      {"ObjCutBehindAVertex", "a.obj", kSquare,
       "a.obj:4: the file ends without a face: is it cut?"},
      {"FaceOfWords", "a.obj", "v 0 0 0\nf 1 1x 1\n", "a.obj:2: face names no vertex: 1x"},
      {"FaceOfZero", "a.obj", "v 0 0 0\nf 1 0 1\n", "a.obj:2: face names no vertex: 0"},
      {"FaceBeforeTheFirst", "a.obj", "v 0 0 0\nf 1 -2 1\n", "face names no vertex: -2"},
      {"FaceWithADamagedNormal", "a.obj", "v 0 0 0\nf 1 1//x 1\n", "vertex: 1//x"}};
  for (const auto& damage : rows) {
    SCOPED_TRACE(damage.name);
    EXPECT_THAT(test::refusal([&] { parse_mesh(damage.bytes, damage.file, {}); }),
                HasSubstr(damage.sentence));
  }
}

TEST_F(MeshFile, TheBoxIsThatOfTheTriangles) {
  const auto file = folder_.write("a.obj", "v 9 9 9\nl 1 2\n" + kSquare + "f 2 3 4 5\n");
  Eigen::Vector3d centre;
  EXPECT_EQ(bounding_box(load_mesh(file), centre).size_m, Eigen::Vector3d(1, 1, 0));
  EXPECT_EQ(centre, Eigen::Vector3d(0.5, 0.5, 0));
}

TEST_F(MeshFile, AMirroredMeshKeepsItsOuterSide) {
  const auto file = folder_.write("a.obj", kSquare + "f 1 2 3\n");
  EXPECT_EQ(load_mesh(file, {-1, 1, 1}).triangles[0], (std::array<std::uint32_t, 3>{0, 2, 1}));
  EXPECT_EQ(load_mesh(file, {-1, -1, 1}).triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_THAT(test::refusal([&] { load_mesh(file, {1, 0, 1}); }), HasSubstr("scaled by 0"));
  EXPECT_THAT(test::refusal([&] { load_mesh(file, {1e9, 1, 1}); }), HasSubstr("farther away"));
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
