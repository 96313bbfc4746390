// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_body.hpp"

#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"

namespace cas::base {
namespace {

const std::string kInertia = "<inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/>";
const std::string kBody = "<inertial><mass value='1'/>" + kInertia + "</inertial>";

/// A body with an arm on it; an element a line.
std::string urdf(const std::string& body = kBody, const std::string& more = "") {
  return "<robot name='v'>\n<link name='base'>\n" + body +
         "</link>\n<link name='arm'/>\n<joint name='j' type='fixed'>\n<origin xyz='1 0 0'/>"
         "<parent link='base'/><child link='arm'/></joint>\n" +
         more + "</robot>\n";
}

std::string refusal(const std::string& text) {
  return cas::test::refusal([&] { parse_model_body(text, "v.urdf"); });
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(WrongUrdf, IsRefusedByItsOwnFileAndLine) {
  struct UrdfCase {
    const char* name;
    std::string text;
    const char* message;
  };
  const UrdfCase rows[] = {
      {"NegativeMass", urdf(changed(kBody, "'1'", "'-1.16'")),
       "v.urdf:3: <mass> must not be negative"},
      {"Comma", urdf(changed(kBody, "'1'", "'1,16'")),
       "v.urdf:3: 'value' of <mass> is not made of numbers: '1,16' is no number"},
      {"Unit", urdf(changed(kBody, "'1'", "'1.16kg'")), "'1.16kg' is no number"},
      {"TwoNumbers", urdf(changed(kBody, "'1'", "'1 16'")),
       "'value' of <mass> has 2 numbers instead of 1"},
      {"NotFinite", urdf(changed(kBody, "ixx='0.01'", "ixx='NaN'")),
       "v.urdf:3: 'ixx' of <inertia> is not made of numbers"},
      {"NoMoment", urdf(changed(kBody, "ixx='0.01'", "")),
       "v.urdf:3: <inertia> has no attribute 'ixx'"},
      {"NoMass", urdf("<inertial>" + kInertia + "</inertial>"),
       "v.urdf:3: <inertial> has no <mass>"},
      {"TwoRoots", urdf(kBody, "<link name='stand'/>"),
       "v.urdf:7: link 'stand' hangs on no joint, and neither does 'base'"},
      {"NoSuchLink",
       urdf(kBody,
            "<joint name='k' type='fixed'><parent link='base'/><child link='nolink'/></joint>"),
       "v.urdf:7: <child> of a joint names the link 'nolink', which is not there"},
      {"TwoParents",
       urdf(kBody, "<joint name='k' type='fixed'><parent link='base'/><child link='arm'/></joint>"),
       "v.urdf:7: link 'arm' is the child of two joints"},
      {"Ring",
       urdf(kBody, "<joint name='k' type='fixed'><parent link='arm'/><child link='base'/></joint>"),
       "the joints go round in a circle"},
      {"RingBeside",
       urdf(kBody,
            "<link name='a'/><link name='b'/><joint name='k' type='fixed'>"
            "<parent link='a'/><child link='b'/></joint><joint name='l' type='fixed'>"
            "<parent link='b'/><child link='a'/></joint>"),
       "some of the joints go round in a circle"},
      {"SameName", urdf(kBody, "<link name='arm'/>"), "v.urdf:7: a second <link> is called 'arm'"},
      {"SameJoint",
       urdf(kBody,
            "<link name='leg'/><joint name='j' type='fixed'><parent link='base'/>"
            "<child link='leg'/></joint>"),
       "v.urdf:7: a second <joint> is called 'j'"},
      {"CutInATag", urdf().substr(0, urdf().find("='arm'")),
       "v.urdf:4: unclosed token: the file is cut, it ends within <robot> of line 1"},
      {"CutBehindATag", urdf().substr(0, urdf().find("<parent")),
       "v.urdf:6: no element found: the file is cut, it ends within <joint> of line 5"},
      {"Empty", "", "v.urdf:1: no element found: the file is empty, or cut"},
      {"JointType", changed(urdf(), "'fixed'", "'hinge'"),
       "v.urdf:5: joint 'j' has the unknown type 'hinge'"},
      {"Axis",
       changed(changed(urdf(), "'fixed'", "'continuous'"), "<child", "<axis xyz='0 0 0'/><child"),
       "v.urdf:6: joint 'j': <axis> is zero"},
      {"Latin1", changed(urdf(), "'arm'", "'Fl\xFCgel'"), "v.urdf:4: not well-formed"},
      {"Encoding", "<?xml version='1.0' encoding='GB2312'?>" + urdf(),
       "v.urdf:1: unknown encoding"},
      {"Mesh", "<COLLADA/>", "v.urdf:1: is no vehicle model"},
      {"Far",
       changed(changed(urdf(), "1 0 0", "1e308 0 0"), "name='arm'/>",
               "name='arm'>" + kBody + "</link>"),
       "give no finite sum"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_NE(refusal(row.text).find(row.message), std::string::npos) << refusal(row.text);
  }
}

TEST(ModelBody, ABlankPlusIsANumberStill) {
  EXPECT_EQ(parse_model_body(urdf(changed(kBody, "'1'", "' +1.16 '")), "v.urdf").mass_kg, 1.16);
}

/// A chain in which each link hangs on the one before.
std::string chain(std::size_t links) {
  std::string text = "<robot name='v'><link name='l0'>" + kBody + "</link>";
  for (std::size_t i = 1; i < links; ++i) {
    const std::string n = std::to_string(i);
    text += "<link name='l" + n + "'/><joint name='j" + n + "' type='fixed'><parent link='l" +
            std::to_string(i - 1) + "'/><child link='l" + n + "'/></joint>";
  }
  return text + "</robot>";
}

TEST(ModelBody, LinksAreBounded) {
  EXPECT_EQ(parse_model_body(chain(kMaxModelLinks), "v.urdf").links.size(), kMaxModelLinks);
  EXPECT_NE(refusal(chain(20'000)).find("more than the 1000 links"), std::string::npos);
}

TEST(ModelBody, DepthIsBounded) {
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_EQ(refusal("<robot name='v'>" + deep), "v.urdf:1: elements lie more than 200 deep");
}

/// Both formats judge an inertia alike: it is named, and the mass stays.
TEST(ModelBody, AnInertiaThatNoBodyHasIsAPointMassInBothFormats) {
  const std::string sdf =
      "<sdf version='1.9'><model name='v'><link name='base'><inertial><mass>1</mass><inertia>"
      "<ixx>-0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link></model></sdf>";
  for (const std::string& text : {urdf(changed(kBody, "ixx='0.01'", "ixx='-0.01'")), sdf}) {
    const ModelBody body = parse_model_body(text, "v");
    EXPECT_EQ(body.mass_kg, 1);
    EXPECT_TRUE(body.inertia_B_kg_m2.isZero());
    ASSERT_EQ(body.warnings.size(), 1U);
    EXPECT_NE(body.warnings[0].find("link 'base': no body has this <inertia>"), std::string::npos);
  }
}

TEST(ModelBody, WhatIsNotReadOfALinkIsNamed) {
  const std::string box = "<geometry><box size='1 1 1'/>";
  const std::pair<std::string, const char*> cases[] = {
      {kBody + "\n" + kBody, "v.urdf:4: a second <inertial> in <link name='base'> is left out"},
      {kBody + "\n<colision>" + box + "</geometry></colision>",
       "v.urdf:4: <colision> in <link name='base'> is left out: no such element"},
      {kBody + "<collision>" + box + "\n<sphere radius='9'/></geometry></collision>",
       "v.urdf:4: link 'base': of a <geometry> the first form counts, <box>; <sphere> is left"},
      {kBody + "<visual>\n" + changed(box, "1 1 1", "1 1 1,5") + "</geometry></visual>",
       "'1,5' is no number (decimals follow a point, not a comma); link 'base' is drawn without"},
      {kBody + "<collision>\n<orgin xyz='0 0 1'/>" + box + "</geometry></collision>",
       "v.urdf:4: <orgin> in <collision> of <link name='base'> is left out: no such element"},
      {kBody + "<collision>\n<origin xzy='0 0 1'/>" + box + "</geometry></collision>",
       "v.urdf:4: 'xzy' of <origin> of <link name='base'> is left out: no such attribute"},
      {kBody + "<collision><origin/>\n<origin xyz='0 0 1'/>" + box + "</geometry></collision>",
       "v.urdf:4: a second <origin> in <collision> of <link name='base'> is left out"},
      {kBody + "<collision>" + box + "</geometry>\n" + box + "</geometry></collision>",
       "v.urdf:4: a second <geometry> in <collision> of <link name='base'> is left out"},
      {kBody + "<collision><geometry>\n<box size='1 1 1' scale='2'/></geometry></collision>",
       "v.urdf:4: 'scale' of <box> of <link name='base'> is left out"},
      {changed(kBody, "<mass", "\n<pose>0 0 1</pose><mass"),
       "v.urdf:4: <pose> in <inertial> of <link name='base'> is left out"}};
  for (const auto& [inside, sentence] : cases) {
    const ModelBody body = parse_model_body(urdf(inside), "v.urdf");
    EXPECT_EQ(body.mass_kg, 1);
    ASSERT_EQ(body.warnings.size(), 1U) << sentence;
    EXPECT_NE(body.warnings[0].find(sentence), std::string::npos) << body.warnings[0];
  }
  const std::string joint = changed(urdf(), "'1 0 0'", "'1 0 0' quat='0 0 0 1'");
  const std::string macro = urdf(kBody, "<x:rotor n='1'/><drake:joint/><material/>");
  for (const auto& [text, sentence] :
       {std::pair(joint, "v.urdf:6: 'quat' of <origin> of <joint name='j'> is left out"),
        std::pair(macro, "v.urdf:7: <x:rotor> in <robot> is left out: no such element")}) {
    const ModelBody body = parse_model_body(text, "v.urdf");
    ASSERT_EQ(body.warnings.size(), 1U) << sentence;
    EXPECT_NE(body.warnings[0].find(sentence), std::string::npos) << body.warnings[0];
  }
  EXPECT_NE(refusal(urdf(kBody + "<collision/>")).find("v.urdf:3: <collision> has no <geometry>"),
            std::string::npos);
}

TEST(ModelBody, AnglesInDegreesAreNamedInBothFormats) {
  const std::string sdf =
      "<sdf version='1.9'><model name='v'><link name='base'><inertial><mass>1</mass><inertia><ixx>1"
      "</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>\n<collision name='c'><pose>0 0 9 0 0 90"
      "</pose><geometry><box><size>1 1 1</size></box></geometry></collision></link></model></sdf>";
  const std::string rolled =
      urdf(kBody +
           "<collision>\n<origin xyz='0 0 9' rpy='0 -45 0'/><geometry><box size='1 1 1'/>"
           "</geometry></collision>");
  for (const auto& [text, sentence] :
       {std::pair(rolled,
                  "v:4: an angle of -45 rad is more than a full turn: it may be in degrees"),
        std::pair(sdf, "v:2: an angle of 90 rad is more than a full turn")}) {
    const ModelBody body = parse_model_body(text, "v");
    ASSERT_EQ(body.warnings.size(), 1U) << sentence;
    EXPECT_NE(body.warnings[0].find(sentence), std::string::npos) << body.warnings[0];
  }
  EXPECT_TRUE(parse_model_body(changed(sdf, "<pose>", "<pose degrees='1'>"), "v").warnings.empty());
  EXPECT_TRUE(parse_model_body(changed(rolled, "-45", "6.2832"), "v").warnings.empty());
}

TEST(ModelBody, WhatHoldsTheModelInGazeboIsNamed) {
  const std::string sdf =
      "<sdf version='1.9'><model name='v'>\n<static>true</static><link "
      "name='base'><inertial><mass>1"
      "</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link></model>"
      "</sdf>";
  const ModelBody body = parse_model_body(sdf, "v");
  ASSERT_EQ(body.warnings.size(), 1U);
  EXPECT_NE(body.warnings[0].find("v:2: <static> holds the model in Gazebo"), std::string::npos);
  EXPECT_TRUE(parse_model_body(changed(sdf, ">true<", ">0<"), "v").warnings.empty());
}

TEST(ModelBody, AJointThatMovesAndIsNoRotorIsNamedInBothFormats) {
  const std::string inertial =
      "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>";
  const std::string sdf =
      "<sdf version='1.9'><model name='v'><link name='base'>" + inertial +
      "</link><link name='arm'>" + inertial +
      "</link><joint name='j' type='revolute'><parent>base</parent><child>arm</child><axis><limit>"
      "<lower>-1</lower><upper>1</upper></limit></axis></joint></model></sdf>";
  for (const std::string& text : {changed(urdf(), "'fixed'", "'revolute'"), sdf}) {
    const ModelBody body = parse_model_body(text, "v");
    ASSERT_EQ(body.warnings.size(), 1U);
    EXPECT_NE(body.warnings[0].find("joint 'j' moves"), std::string::npos);
  }
  EXPECT_TRUE(
      parse_model_body(changed(sdf, "<lower>-1</lower><upper>1<", "<lower>0</lower><upper>0<"), "v")
          .warnings.empty())
      << "between equal limits nothing moves";
}

}  // namespace
}  // namespace cas::base
