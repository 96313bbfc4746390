// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/collada.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "libsim/core/load/mesh_file.hpp"
#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kZUp = "<up_axis>Z_UP</up_axis>";

std::string document(const std::string& asset, const std::string& geometries,
                     const std::string& nodes, const std::string& libraries = "") {
  return "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema'>\n<asset>" + asset +
         "</asset>\n<library_geometries>" + geometries + "</library_geometries>" + libraries +
         "<library_visual_scenes><visual_scene id='s'>" + nodes +
         "</visual_scene></library_visual_scenes>\n"
         "<scene><instance_visual_scene url='#s'/></scene></COLLADA>";
}

/// A unit square of the x-y plane at this height; its own ids end in `ids`.
std::string geometry(const std::string& id, const std::string& ids, const std::string& faces,
                     const std::string& z = "0") {
  return "<geometry id='" + id + "'><mesh><source id='p" + ids + "'><float_array id='a" + ids +
         "' count='12'>0 0 " + z + "  1 0 " + z + "  1 1 " + z + "\n 0 1 " + z +
         "</float_array><technique_common><accessor source='#a" + ids +
         "' count='4' stride='3'/></technique_common></source><vertices id='v" + ids +
         "'><input semantic='POSITION' source='#p" + ids + "'/></vertices>" + faces +
         "</mesh></geometry>";
}

std::string faces(const std::string& name, const std::string& lists) {
  return "<" + name + "><input semantic='VERTEX' source='#v' offset='0'/>" + lists + "</" + name +
         ">";
}

const std::string kTriangles =
    "<triangles count='2'><input semantic='VERTEX' source='#v' offset='0'/>"
    "<input semantic='NORMAL' source='#n' offset='1'/><p>0 0 1 0 2 0 0 0 2 0 3 0</p></triangles>";
const std::string kPlaced = "<node><instance_geometry url='#g'/></node>";

TriangleMesh parse(const std::string& text, std::vector<std::string>* warnings = nullptr,
                   UpAxis up_axis = UpAxis::kIgnored) {
  return parse_mesh(text, "m.dae", {.up_axis = up_axis, .warnings = warnings});
}

std::string refusal(const std::string& text) {
  return test::refusal([&] { parse(text); });
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Collada, NodesPlaceTheirGeometries) {
  const TriangleMesh mesh = parse(document(
      kZUp, geometry("g", "", kTriangles),
      "<node><translate>10 0 0</translate><node><matrix>1 0 0 0 0 1 0 0 0 0 1 2 0 0 0 1</matrix>"
      "<rotate>0 0 1 0</rotate><instance_geometry url='#g'/></node></node>"));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_LT((mesh.vertices[2] - Eigen::Vector3d(11, 1, 2)).norm(), 1e-12);
}

TEST(Collada, AFileWithoutASceneHasAllItsGeometries) {
  std::string text =
      document(kZUp, geometry("g", "", kTriangles) + geometry("h", "", kTriangles), kPlaced);
  text.erase(text.find("<scene>"),
             std::string("<scene><instance_visual_scene url='#s'/></scene>").size());
  EXPECT_EQ(parse(text).triangles.size(), 2u) << "those of its visual scene";
  const std::size_t scenes = text.find("<library_visual_scenes>");
  text.insert(scenes, "<library_geometries><asset/>" + geometry("k", "", kTriangles) +
                          "</library_geometries>");
  EXPECT_EQ(parse(text).triangles.size(), 2u);
  const std::string two = changed(text, "</visual_scene>", "</visual_scene><visual_scene/>");
  EXPECT_THAT(refusal(two), HasSubstr("is a second <visual_scene>, and no <scene> says which"));
  const std::size_t end = text.find("</library_visual_scenes>");
  text.erase(text.find("<visual_scene id"), end - text.find("<visual_scene id"));
  EXPECT_EQ(parse(text).triangles.size(), 6u) << "of both libraries";
}

TEST(Collada, ATransformationBehindAGeometryPlacesIt) {
  const TriangleMesh mesh =
      parse(document(kZUp, geometry("g", "", kTriangles),
                     "<node><instance_geometry url='#g'/><node><instance_geometry url='#g'/></node>"
                     "<translate>0 0 7</translate></node>"));
  ASSERT_EQ(mesh.vertices.size(), 8u);
  for (const Eigen::Vector3d& v : mesh.vertices) EXPECT_EQ(v.z(), 7);
}

TEST(Collada, UpAxisTurnsTheMeshWhereThatIsWanted) {
  const std::string text = document("<unit meter='0.1'/><up_axis>Y_UP</up_axis>",
                                    geometry("g", "", kTriangles, "2"), kPlaced);
  std::vector<std::string> warnings;
  const TriangleMesh as_it_is = parse(text, &warnings);
  EXPECT_LT((as_it_is.vertices[2] - Eigen::Vector3d(0.1, 0.1, 0.2)).norm(), 1e-12);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("m.dae:2: <up_axis> Y_UP does not turn the mesh")));
  warnings.clear();
  const TriangleMesh turned = parse(text, &warnings, UpAxis::kApplied);
  EXPECT_LT((turned.vertices[2] - Eigen::Vector3d(0.1, -0.2, 0.1)).norm(), 1e-12);
  EXPECT_THAT(warnings, IsEmpty());
  EXPECT_THAT(refusal(document("<up_axis>W_UP</up_axis>", geometry("g", "", kTriangles), kPlaced)),
              HasSubstr("m.dae:2: <up_axis> is X_UP, Y_UP or Z_UP"));
}

TEST(Collada, EveryKindOfFaceIsCutIntoTriangles) {
  const std::pair<std::string, std::size_t> cases[] = {
      {faces("triangles", "<p>0 1 2</p><p>0 2 3</p>"), 2},
      {faces("tristrips", "<p>0 1 3 2</p>"), 2},
      {faces("trifans", "<p>0 1 2 3</p>"), 2},
      {faces("polylist", "<vcount>4 3</vcount><p>0 1 2 3 0 1 2</p>"), 3},
      {faces("polygons", "<p>0 1 2 3</p><p>0 1 2</p>"), 3}};
  for (const auto& [part, triangles] : cases) {
    const TriangleMesh mesh = parse(document(kZUp, geometry("g", "", part), kPlaced));
    EXPECT_EQ(mesh.triangles.size(), triangles) << part;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Eigen::Vector3d normal =
          (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
      EXPECT_GT(normal.z(), 0) << part;
    }
  }
}

TEST(Collada, AMirroredNodeKeepsTheOuterSidesOfItsTriangles) {
  const std::string place = "<instance_geometry url='#g'/></node>";
  const TriangleMesh mesh =
      parse(document(kZUp, geometry("g", "", kTriangles),
                     "<node>" + place + "<node><scale>-1 1 1</scale>" + place +
                         "<node><matrix>0 1 0 0 1 0 0 0 0 0 -1 0 0 0 0 1</matrix>" + place));
  ASSERT_EQ(mesh.triangles.size(), 6u);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[2], (std::array<std::uint32_t, 3>{4, 6, 5}));
  EXPECT_EQ(mesh.triangles[4], (std::array<std::uint32_t, 3>{8, 9, 10})) << "no mirror: it turns";
}

TEST(Collada, EachGeometryHasItsOwnSourcesWhenAllHaveTheSameIds) {
  const TriangleMesh mesh =
      parse(document(kZUp, geometry("g", "", kTriangles, "1") + geometry("h", "", kTriangles, "5"),
                     "<node id='g'><instance_geometry url='#g'/></node>"
                     "<node id='h'><instance_geometry url='#h'/></node>"));
  ASSERT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(mesh.vertices[0].z(), 1);
  EXPECT_EQ(mesh.vertices[4].z(), 5);
}

TEST(Collada, AnIdThatMeansTwoThingsIsRefused) {
  EXPECT_THAT(
      refusal(document(kZUp, geometry("g", "", kTriangles) + "\n" + geometry("g", "", kTriangles),
                       kPlaced)),
      HasSubstr("names the <geometry> 'g', and that id occurs twice, in lines 3 and 5"));
}

TEST(Collada, WhatIsNotReadIsNamed) {
  const std::pair<std::string, const char*> cases[] = {
      {document(kZUp, geometry("g", "", kTriangles),
                kPlaced + "\n<node><instance_controller url='#c'/></node>"),
       "<instance_controller> is left out: skins and morphs are not read"},
      {document(kZUp, geometry("g", "", kTriangles + faces("polygons", "<ph><p>0 1 2</p></ph>")),
                kPlaced),
       "<ph> is left out: polygons with holes are not read"},
      {document(kZUp,
                geometry("g", "",
                         kTriangles + "<triangles count='4'><input semantic='VERTEX' source='#v' "
                                      "offset='0'/></triangles>"),
                kPlaced),
       "<triangles> promises 4 faces and has 0"},
      {document(kZUp, geometry("g", "", changed(kTriangles, "count='2'", "count='12'")), kPlaced),
       "m.dae:4: <triangles> promises 12 faces and has 2"},
      {document(kZUp,
                geometry("g", "",
                         changed(faces("polygons", "<p>0 1 2</p><p>0 2 3</p>"), "<polygons",
                                 "<polygons count='3'")),
                kPlaced),
       "<polygons> promises 3 faces and has 2"},
      {document("<unit name='inch'/>" + kZUp, geometry("g", "", kTriangles), kPlaced),
       "m.dae:2: <unit> 'inch' has no 'meter': the numbers are taken as metres"},
      {document(kZUp, geometry("g", "", kTriangles) + "<geometry id='h'><spline/></geometry>",
                kPlaced + "<node><instance_geometry url='#h'/></node>"),
       "<spline> is left out"},
      {document(kZUp,
                geometry("g", "", kTriangles + faces("polylist", "<vcount>2</vcount><p>0 1</p>")),
                kPlaced),
       "faces of fewer than three corners are left out"}};
  for (const auto& [text, sentence] : cases) {
    std::vector<std::string> warnings;
    EXPECT_EQ(parse(text, &warnings).triangles.size(), 2u);
    EXPECT_THAT(warnings, ElementsAre(HasSubstr(sentence)));
  }
}

/// The good file with this node instead.
std::string with_node(const std::string& transformation) {
  return document(kZUp, geometry("g", "", kTriangles),
                  "\n<node>" + transformation + "<instance_geometry url='#g'/></node>");
}

std::string with_faces(const std::string& part) {
  return document(kZUp, geometry("g", "", "\n" + part), kPlaced);
}

TEST(ColladaFault, IsRefusedWithItsLine) {
  struct Fault {
    const char* name;
    std::string text;
    const char* sentence;
  };
  const Fault rows[] = {
      {"Empty", "<COLLADA/>", "m.dae: mesh has no triangle"},
      {"SkinAlone", document(kZUp, "", "\n<node><instance_controller url='#c'/></node>"),
       "m.dae: mesh has no triangle; m.dae:4: <instance_controller> is left out"},
      {"Cut", "<COLLADA>\n<scene", "m.dae:2: "},
      {"AnotherFormat", "<svg/>", "m.dae: is no COLLADA file"},
      {"NoScene", "<COLLADA>\n<scene><instance_visual_scene url='#x'/></scene></COLLADA>",
       "m.dae:2: <instance_visual_scene> names the <visual_scene> 'x', which the file does "
       "not have"},
      {"CommaInUnit", document("<unit meter='0,01'/>", geometry("g", "", kTriangles), kPlaced),
       "m.dae:2: <unit>: 'meter': '0,01' is no number (decimals follow a point"},
      {"UnitOfZero", document("<unit meter='0'/>", geometry("g", "", kTriangles), kPlaced),
       "m.dae:2: <unit>: 'meter' must be above 0"},
      {"CommaInAPosition", document(kZUp, geometry("g", "", kTriangles, "0,5"), kPlaced),
       "m.dae:3: <float_array>: '0,5' is no number"},
      {"CommaInTranslate", with_node("<translate>0 0 -0,05</translate>"),
       "m.dae:5: <translate>: '-0,05' is no number"},
      {"ShortTranslate", with_node("<translate>0 1</translate>"),
       "m.dae:5: <translate> has 2 numbers instead of 3"},
      {"ShortMatrix", with_node("<matrix>1 0 0 0 0 1 0 0 0 0 1 0</matrix>"),
       "<matrix> has 12 numbers instead of 16"},
      {"TransposedMatrix", with_node("<matrix>1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1</matrix>"),
       "the last row of <matrix> must be 0 0 0 1"},
      {"RotateWithoutAxis", with_node("<rotate>0 0 0 90</rotate>"), "axis of length zero"},
      {"Skew", with_node("<skew>30 1 0 0 0 1 0</skew>"), "m.dae:5: <skew> is not read"},
      {"FaceOfNoVertex", with_faces(faces("triangles", "<p>0 1 4</p>")),
       "m.dae:5: <p> names the vertex 4, and there are 4"},
      {"HalfATriangle", with_faces(faces("triangles", "<p>0 1 2 3</p>")),
       "m.dae:5: <p> ends within a triangle"},
      {"NegativeIndex", with_faces(faces("triangles", "<p>0 1 -1</p>")),
       "m.dae:5: <p>: '-1' is no number"},
      {"PolylistTooShort", with_faces(faces("polylist", "<vcount>4</vcount><p>0 1 2</p>")),
       "fewer corners than <vcount> promises"},
      {"PolylistTooLong", with_faces(faces("polylist", "<vcount>3</vcount><p>0 1 2 3</p>")),
       "more corners than <vcount> promises"},
      {"TwoNumbersAPosition",
       document(kZUp, changed(geometry("g", "", kTriangles), "stride='3'", "stride='2'"), kPlaced),
       "m.dae:4: a position has three numbers, and 'stride' is 2"},
      {"AnotherFile", changed(with_node(""), "'#g'", "'other.dae#g'"),
       "m.dae:5: <instance_geometry> names the <geometry> 'other.dae#g', and other files "
       "are not read with this one"},
      {"UnknownList", with_faces(faces("polylist", "<vcount>3</vcount><pp>0 1 2</pp>")),
       "<pp> is not read"},
      {"UnknownFaces", with_faces(faces("tripatches", "<p>0 1 2</p>")),
       "m.dae:5: <tripatches> is not read: without it the mesh has another shape"},
      {"NoVertices", with_faces("<triangles><p>0 1 2</p></triangles>"),
       "<triangles> has no <input semantic='VERTEX'>"},
      {"NodesInACircle",
       document(kZUp, geometry("g", "", kTriangles), "<instance_node url='#n'/>",
                "<library_nodes><node id='n'><instance_node url='#n'/></node></library_nodes>"),
       "nodes that name each other without end"},
      {"NodesThatDouble",
       document(kZUp, geometry("g", "", kTriangles), "<instance_node url='#n'/>",
                "<library_nodes><node id='n'><instance_node url='#m'/><instance_node "
                "url='#m'/></node><node id='m'><instance_node url='#n'/><instance_node "
                "url='#n'/></node></library_nodes>"),
       "without end"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_THAT(refusal(row.text), HasSubstr(row.sentence));
  }
}

/// Twenty nodes, each of which names the next one twice, have a million leaves.
TEST(Collada, NodesThatDoubleAreCounted) {
  std::string nodes;
  for (int i = 0; i < 20; ++i) {
    const std::string next = "<instance_node url='#n" + std::to_string(i + 1) + "'/>";
    nodes += "<node id='n" + std::to_string(i) + "'>" + next + next + "</node>";
  }
  EXPECT_THAT(refusal(document(kZUp, geometry("g", "", kTriangles), "<instance_node url='#n0'/>",
                               "<library_nodes>" + nodes + "<node id='n20'/></library_nodes>")),
              HasSubstr("more than 1000000 elements of nodes are named from here"));
}

/// A thousand times a thousand elements without a triangle.
TEST(Collada, ElementsOfNodesAreCountedAsOftenAsTheyAreNamed) {
  std::string turns;
  std::string uses;
  for (int i = 0; i < 1000; ++i) turns += "<rotate>0 0 1 0</rotate>";
  for (int i = 0; i < 1000; ++i) uses += "<instance_node url='#n'/>";
  EXPECT_THAT(refusal(document(kZUp, geometry("g", "", kTriangles), uses,
                               "<library_nodes><node id='n'>" + turns + "</node></library_nodes>")),
              HasSubstr("more than 1000000 elements of nodes"));
}

/// Each <triangles> looks for its vertices: among many, too, without a search through all.
TEST(Collada, ManyPartsOfAMeshAreRead) {
  std::string sources;
  std::string parts;
  for (int i = 0; i < 20'000; ++i) {
    sources += "<source id='s" + std::to_string(i) + "'/>";
    parts += faces("triangles", "<p>0 1 2</p>");
  }
  EXPECT_EQ(parse(document(kZUp, geometry("g", "", sources + parts), kPlaced)).triangles.size(),
            20'000u);
}

TEST(Collada, ElementsInEachOtherAreCounted) {
  std::string text = "<COLLADA>\n";
  for (int i = 0; i < 20'000; ++i) text += "<extra>";
  EXPECT_THAT(refusal(text), HasSubstr("m.dae:2: elements lie more than 200 deep"));
}

}  // namespace
}  // namespace cas::sim
