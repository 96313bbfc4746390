// SPDX-License-Identifier: BSD-3-Clause
// Parts of a world that are in other files, stand in other frames, or are not what SDF knows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libsim/core/load/world_loader.hpp"
#include "tests/libsim/support/sdf_elements.hpp"
#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using test::load_elements;
using test::world_of;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

std::string link_of(const std::string& name, const std::string& geometry, const char* pose = "") {
  return "<link name='" + name + "'>" + pose + "<collision name='c'><geometry>" + geometry +
         "</geometry></collision></link>";
}

std::string static_model(const std::string& name, const std::string& inside) {
  return "<model name='" + name + "'><static>1</static>\n" + inside + "</model>";
}

const std::string kUnitBox = "<box><size>1 1 1</size></box>";

class PartsOfAWorld : public testing::Test {
 protected:
  void write_model(const std::string& name, const std::string& inside) {
    const std::string folder = "models/" + name;
    folder_.write(folder + "/model.config",
                  "<model><name>" + name + "</name><sdf version='1.7'>model.sdf</sdf></model>");
    folder_.write(folder + "/model.sdf",
                  "<sdf version='1.7'>\n" + static_model(name, inside) + "</sdf>\n");
  }
  WorldModel load(const std::string& elements, Missing missing = Missing::kError) {
    return load_sdf_world(folder_.write("worlds/w.sdf", world_of(elements)), {}, missing);
  }
  std::string refusal(const std::string& elements) {
    return test::refusal([&] { load(elements); });
  }
  cas::test::TemporaryFolder folder_;
};

TEST_F(PartsOfAWorld, AModelThatAnIncludedOneIncludesIsFoundBesideIt) {
  write_model("roof", link_of("l", kUnitBox));
  write_model("house", link_of("l", kUnitBox) +
                           "<include><uri>\n model://roof\n</uri><pose>0 0 3 0 0 0"
                           "</pose></include>");
  const WorldModel model =
      load("<include><uri>../models/house</uri><pose>5 0 0 0 0 0</pose></include>");
  ASSERT_EQ(model.statics.size(), 2u);
  EXPECT_TRUE(model.statics[1].pose.translation().isApprox(Eigen::Vector3d(5, 0, 3)));
}

TEST_F(PartsOfAWorld, AModelThatAnIncludedOneMissesIsNamedWithItsPlace) {
  write_model("house", link_of("l", kUnitBox) + "\n<include><uri>model://roof</uri></include>");
  const std::string house = "<include><uri>../models/house</uri></include>";
  EXPECT_THAT(refusal(house), AllOf(HasSubstr("house/model.sdf:4: model model://roof is nowhere"),
                                    HasSubstr("models/house/roof")));
  EXPECT_THAT(load(house, Missing::kIgnore).warnings,
              Contains(HasSubstr("house/model.sdf:4: model model://roof is nowhere to be found; "
                                 "left out")));
}

TEST_F(PartsOfAWorld, AMergedModelIsPartOfAWorldsOwnModel) {
  write_model("roof", link_of("l", kUnitBox));
  EXPECT_EQ(load(static_model("house", "<include merge='true'><uri>../models/roof</uri></include>"))
                .statics.size(),
            1u);
}

TEST_F(PartsOfAWorld, APoseOfAnIncludeThatIsNoneIsRefused) {
  write_model("roof", link_of("l", kUnitBox));
  const auto posed = [](const std::string& pose) {
    return "<include>\n<uri>../models/roof</uri>\n<pose>" + pose + "</pose></include>";
  };
  EXPECT_THAT(refusal(posed("5 0 0")), HasSubstr("w.sdf:5: the <pose> of an <include> has 3 "));
  EXPECT_THAT(refusal(posed("1,5 0 0 0 0 0")), HasSubstr("w.sdf:5: the <pose> of an <include> is "
                                                         "no pose: '1,5' is no number"));
  EXPECT_EQ(load(posed("")).statics.size(), 1u);
  write_model("house", link_of("l", kUnitBox) + posed("5 0 x 0 0 0"));
  EXPECT_THAT(refusal("<include><uri>../models/house</uri></include>"),
              HasSubstr("model.sdf:5: the <pose> of an <include> is no pose: 'x'"));
}

TEST_F(PartsOfAWorld, AUriThatMeansTwoFilesIsRefused) {
  write_model("roof", link_of("l", kUnitBox));
  write_model("house", link_of("l", kUnitBox) + "<include><uri>tile</uri></include>");
  folder_.write("models/house/tile",
                "<sdf version='1.7'>" + static_model("tile", link_of("l", kUnitBox)) + "</sdf>");
  folder_.write("worlds/tile",
                "<sdf version='1.7'>" + static_model("tile", link_of("l", kUnitBox)) + "</sdf>");
  EXPECT_THAT(refusal("<include><uri>tile</uri></include>"
                      "<include><uri>../models/house</uri></include>"),
              HasSubstr("model.sdf:3: the <uri> tile means "));
}

TEST_F(PartsOfAWorld, AnIncludedFileThatCannotBeReadIsNamedWithItsLine) {
  write_model("roof", link_of("l", "<box><size>1 1</size></box>"));
  EXPECT_THAT(refusal("<include><uri>../models/roof</uri></include>"),
              AllOf(HasSubstr("Unable to read file"), HasSubstr("roof/model.sdf:3: ")));
}

TEST(SdfWorldParts, AFrameThatIsNotThereIsRefused) {
  const auto refusal = [](const std::string& elements) {
    return test::refusal([&] { load_elements(elements); });
  };
  const char* const in_oak = "<pose relative_to='oak'>1 2 3 0 0 0</pose>";
  EXPECT_THAT(refusal(static_model("m", in_oak + link_of("l", kUnitBox))),
              HasSubstr("w.sdf:3: <model name='m'> stands in the frame 'oak', which is nowhere"));
  EXPECT_THAT(refusal(static_model("m", link_of("l", kUnitBox, in_oak))),
              HasSubstr("w.sdf:4: <link name='l'> stands in the frame 'oak'"));
  EXPECT_TRUE(load_elements("<frame name='oak'><pose>1 0 0 0 0 0</pose></frame>" +
                            static_model("m", in_oak + link_of("l", kUnitBox)))
                  .statics.at(0)
                  .pose.translation()
                  .isApprox(Eigen::Vector3d(2, 2, 3)));
}

TEST(SdfWorldParts, WhatSdfDoesNotKnowIsTold) {
  const std::pair<std::string, const char*> cases[] = {
      {static_model("m", link_of("l", kUnitBox) + "<colision name='d'/>"),
       "w.sdf:3: <colision> in <model name='m'> is left out: no such element"},
      {static_model("m", link_of("l", "<sphere><raduis>3</raduis></sphere>")),
       "w.sdf:4: <raduis> in <sphere> is left out: no such element"},
      {static_model("m", link_of("l", "<sphere><raduis>3</raduis></sphere>")),
       "collision 'm/c': <sphere> has no <radius>: 1 m, as SDF has it"},
      {static_model("m", link_of("l", kUnitBox, "<pose relativ_to='x'>1 0 0 0 0 0</pose>")),
       "w.sdf:4: XML Attribute[relativ_to] in element[pose] not defined in SDF"},
      {static_model("m", link_of("l", kUnitBox + "<sphere><radius>1</radius></sphere>")),
       "collision 'm/c': <sphere> is left out: one form of a <geometry> counts, <box> here"},
      {static_model("m", link_of("l", "")),
       "w.sdf:4: collision 'm/c' has no form in its <geometry>"},
      {static_model("m",
                    link_of("l", kUnitBox, "<pose>1 0 0 0 0 0</pose><pose>2 0 0 0 0 0</pose>")),
       "w.sdf:4: a second <pose> in <link name='l'> is left out"},
      {static_model("m", link_of("l", kUnitBox) + "\n" + link_of("l", kUnitBox)),
       "w.sdf:5: a second <link name='l'> in <model name='m'> is left out"},
      {static_model("m", link_of("l", kUnitBox)) + "\n" + static_model("m", link_of("l", kUnitBox)),
       "w.sdf:5: a second <model name='m'> in <world name='w'> is left out"},
      {"<spherical_coordinates><surface_model>EARTH_WGS84</surface_model><latitude_deg>47"
       "</latitude_deg><elevation>4</elevation></spherical_coordinates>",
       "w.sdf:3: <spherical_coordinates> has no <longitude_deg>: 0, as SDF has it"},
      {"<actor name='a'>" + link_of("l", "<ellipsoid><radii>1 1 1</radii></ellipsoid>") +
           "</actor>",
       "w.sdf:3: collision 'a/c': <ellipsoid> is left out"}};
  for (const auto& [elements, sentence] : cases) {
    EXPECT_THAT(load_elements(elements).warnings, Contains(HasSubstr(sentence)));
  }
  EXPECT_THAT(
      load_elements(static_model("m", link_of("l", kUnitBox) + link_of("k", kUnitBox) +
                                          "<gz:tag/><plugin name='p' filename='f'><x/></plugin>"))
          .warnings,
      testing::ElementsAre(HasSubstr("<plugin name='p'> is left out")));
}

}  // namespace
}  // namespace cas::sim
