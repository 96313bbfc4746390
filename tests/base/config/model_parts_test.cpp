// SPDX-License-Identifier: BSD-3-Clause
// SDF models that are put together from parts.
#include <gmock/gmock.h>

#include "base/config/model_body.hpp"
#include "base/config/vehicle.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

using testing::HasSubstr;

constexpr double kRounding = 1e-12;

std::string inertial(double mass) {
  return "<inertial><mass>" + std::to_string(mass) +
         "</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>";
}

std::string model(const std::string& name, const std::string& inside) {
  return "<sdf version='1.9'>\n<model name='" + name + "'>\n" + inside + "</model>\n</sdf>\n";
}

const std::string kBase = "<link name='base'>" + inertial(1) + "</link>\n";
const std::string kTurning =
    "<joint name='yaw' type='revolute'><parent>base</parent><child>camera</child><axis><xyz>0 0 "
    "1</xyz><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis></joint>";

class PartsOfAModel : public testing::Test {
 protected:
  PartsOfAModel() {
    folder_.write("gps/model.config", "<model><sdf version='1.6'>gps.sdf</sdf></model>");
    folder_.write(
        "gps/gps.sdf",
        model("gps", "<pose>9 9 9 0 0 0</pose><link name='link'><pose>0 0 0.5 0 0 0</pose>" +
                         inertial(0.5) + "</link>"));
  }
  ModelBody read(const std::string& inside, const ModelParts& parts = {}) {
    return *read_model_body(folder_.write("v/model.sdf", model("v", inside)), parts);
  }
  std::string refusal(const std::string& inside, const ModelParts& parts = {}) {
    return cas::test::refusal([&] { read(inside, parts); });
  }
  cas::test::TemporaryFolder folder_;
};

TEST_F(PartsOfAModel, AnIncludedModelBesideTheVehiclesFolderIsAFixedMass) {
  const ModelBody body = read(
      kBase +
      "<include><uri>model://gps</uri><name>gps0</name><pose>1 0 0 0 0 1.5707963267948966</pose>"
      "</include><joint name='g' type='fixed'><parent>base</parent><child>gps0::link</child>"
      "</joint>");
  EXPECT_NEAR(body.mass_kg, 1.5, kRounding);
  ASSERT_NE(body.find("gps0::link"), nullptr);
  EXPECT_EQ(body.find("link"), body.find("gps0::link")) << "the only one of that name";
  EXPECT_EQ(body.find("ink"), nullptr);
  // The include's pose takes the place of the model's own.
  EXPECT_TRUE(body.find("gps0::link")->position_R_m.isApprox(Eigen::Vector3d(1, 0, 0.5)));
  EXPECT_TRUE(body.warnings.empty());
}

TEST_F(PartsOfAModel, AnIncludedModelMayBeNamedWithoutAScheme) {
  EXPECT_NEAR(read(kBase + "<include><uri>gps</uri></include>").mass_kg, 1.5, kRounding);
}

TEST_F(PartsOfAModel, PosesOfOtherVersionsAreRead) {
  const auto foot_with = [&](const std::string& pose) {
    return kBase + "<link name='arm'><pose>1 0 0 0 0 1.5707963267948966</pose>" + inertial(0.1) +
           "</link><link name='foot'>" + pose + inertial(0.1) + "</link>";
  };
  for (const char* pose :
       {"<pose frame='arm'>2 0 0 0 0 0</pose>",  // SDF 1.5 and 1.6
        "<pose relative_to='arm' rotation_format='quat_xyzw'>2 0 0 0 0 0.7 0.7</pose>"}) {
    const ModelBody body = read(foot_with(pose));
    EXPECT_TRUE(body.find("foot")->position_R_m.isApprox(Eigen::Vector3d(1, 2, 0))) << pose;
  }
  EXPECT_THAT(refusal(foot_with("<pose frame='leg'>0 0 0 0 0 0</pose>")), HasSubstr("frame 'leg'"));
  EXPECT_THAT(refusal(foot_with("<pose rotation_format='quat_xyzw'>0 0 0 0 0 0 0</pose>")),
              HasSubstr("the quaternion of a <pose> has no length"));
}

TEST_F(PartsOfAModel, AMergedModelsLinksAreTheVehiclesOwn) {
  folder_.write(
      "frame/model.sdf",
      model("frame", kBase + "<link name='camera'><pose relative_to='base'>0 2 0 0 0 0</pose>" +
                         inertial(0.1) + "</link>"));
  const ModelBody body = read(
      "<include merge='true'><uri>model://frame</uri><pose>0 0 3 0 0 0</pose></include>"
      "<frame name='mount' attached_to='camera'><pose>0 0 1 0 0 0</pose></frame>"
      "<link name='foot'><pose relative_to='mount'>1 0 0 0 0 0</pose>" +
      inertial(0.2) + "</link>" + kTurning);
  EXPECT_NEAR(body.mass_kg, 1.3, kRounding);
  EXPECT_TRUE(body.find("foot")->position_R_m.isApprox(Eigen::Vector3d(1, 2, 4)));
  EXPECT_TRUE(body.find("camera")->axis_R.has_value()) << "its joint is outside the merged model";
}

TEST_F(PartsOfAModel, ANestedModelStandsByItsPlacementFrame) {
  const ModelBody body =
      read(kBase +
           "<model name='gps' placement_frame='link'><pose>0 0 1 0 0 0</pose><link name='link'>"
           "<pose>0 0 5 0 0 0</pose>" +
           inertial(0.5) + "</link><model name='antenna'><link name='link'>" + inertial(0.25) +
           "</link></model></model>");
  EXPECT_TRUE(body.find("gps::link")->position_R_m.isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE(body.find("gps::antenna::link")->position_R_m.isApprox(Eigen::Vector3d(0, 0, -4)));
  EXPECT_NEAR(body.mass_kg, 1.75, kRounding);
}

TEST_F(PartsOfAModel, AMissingIncludeIsNamedWithBothRemedies) {
  const std::string inside =
      kBase + "<include><uri>model://lidar</uri><name>front</name></include>";
  const std::string why = refusal(inside);
  for (const char* part : {"v/model.sdf:4: ", "model://lidar is nowhere to be found",
                           "GZ_SIM_RESOURCE_PATH", "`parts: {front: left_out}`"}) {
    EXPECT_THAT(why, HasSubstr(part)) << part << " in " << why;
  }
  EXPECT_NEAR(read(inside, {{"front", PartUse::kLeftOut}}).mass_kg, 1, kRounding);
  EXPECT_NEAR(read(inside, {{"lidar", PartUse::kLeftOut}}).mass_kg, 1, kRounding);
}

TEST_F(PartsOfAModel, ATemplateBesideAnIncludedFileIsNamed) {
  folder_.write("iris/model.config", "<model><sdf>iris.sdf</sdf></model>");
  folder_.write("iris/iris.sdf.jinja", "{% set x = 1 %}");
  EXPECT_THAT(refusal("<include><uri>model://iris</uri></include>"),
              HasSubstr("iris.sdf.jinja is a"));
}

TEST_F(PartsOfAModel, ModelsThatIncludeThemselvesEnd) {
  EXPECT_THAT(refusal(kBase + "<include><uri>model://v</uri></include>"), HasSubstr("without end"));
}

TEST_F(PartsOfAModel, APartThatIsNotThereIsRefused) {
  EXPECT_THAT(refusal(kBase, {{"gimbal", PartUse::kFixed}}), HasSubstr("'gimbal', which `parts`"));
}

TEST_F(PartsOfAModel, ALinkIsLeftOutOrFixedByItsNameOrItsJoints) {
  const std::string inside = kBase + "<link name='camera'>" + inertial(0.5) + "</link>" + kTurning;
  EXPECT_TRUE(read(inside).find("camera")->axis_R.has_value());
  for (const char* name : {"camera", "yaw"}) {
    const ModelBody fixed = read(inside, {{name, PartUse::kFixed}});
    EXPECT_FALSE(fixed.find("camera")->axis_R.has_value()) << name;
    EXPECT_NEAR(fixed.mass_kg, 1.5, kRounding);
    EXPECT_NEAR(read(inside, {{name, PartUse::kLeftOut}}).mass_kg, 1, kRounding) << name;
  }
}

std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& more = "") {
  return "<joint name='" + name + "' type='revolute'><parent>" + parent + "</parent><child>" +
         child + "</child>" + more + "</joint>\n";
}

TEST_F(PartsOfAModel, AJointMayNameAFrameOrAModelInsteadOfALink) {
  const std::string camera = "<link name='camera'>" + inertial(0.5) + "</link>\n";
  for (const char* child : {"mount", "arm", "camera"}) {
    const ModelBody body = read(kBase + camera +
                                "<frame name='mount' attached_to='camera'/>"
                                "<frame name='arm' attached_to='mount'/>" +
                                joint("yaw", "base", child));
    EXPECT_TRUE(body.find("camera")->axis_R.has_value()) << child;
    EXPECT_TRUE(body.warnings.empty()) << child;
  }
  const ModelBody nested =
      read(kBase + "<model name='gimbal'>" + camera + "</model>" + joint("yaw", "base", "gimbal"));
  EXPECT_TRUE(nested.find("gimbal::camera")->axis_R.has_value());
}

TEST_F(PartsOfAModel, AJointAndALinkMayShareAName) {
  const ModelBody body = read(joint("camera", "base", "camera") + kBase + "<link name='camera'>" +
                              inertial(0.5) + "</link>");
  EXPECT_TRUE(body.find("camera")->axis_R.has_value());
}

TEST_F(PartsOfAModel, AJointToALinkThatIsNotThereIsRefused) {
  EXPECT_THAT(refusal(kBase + joint("yaw", "base", "camrea")),
              HasSubstr("model.sdf:4: the model has no link, joint or frame 'camrea'"));
  EXPECT_THAT(refusal(kBase + joint("yaw", "bas", "base")), HasSubstr("frame 'bas'"));
  EXPECT_THAT(refusal(kBase + "<frame name='f' attached_to='leg'/>"), HasSubstr("frame 'leg'"));
  EXPECT_THAT(refusal(kBase + "<frame name='f' attached_to='f'/>"), HasSubstr("in a circle"));
  EXPECT_THAT(
      refusal(kBase + "<link name='arm'>" + inertial(1) +
              "</link><joint name='j' type='revolut'><parent>base</parent><child>arm</child>"
              "</joint>"),
      HasSubstr("the type 'revolut', which SDF does not have"));
  EXPECT_THAT(refusal(kBase + "<joint name='j' type='fixed'><child>base</child></joint>"),
              HasSubstr("joint 'j' has no <parent>"));
  const std::string lidar = "<include><uri>model://lidar</uri><name>front</name></include>" +
                            joint("mount", "base", "front::link");
  EXPECT_NEAR(read(kBase + lidar, {{"front", PartUse::kLeftOut}}).mass_kg, 1, kRounding)
      << "a joint of what is left out is left out";
}

TEST_F(PartsOfAModel, ALimitMayBeInfinite) {
  const ModelBody body =
      read(kBase + "<link name='camera'>" + inertial(0.5) + "</link>" +
           joint("yaw", "base", "camera",
                 "<axis><limit><lower>-inf</lower><upper> INF </upper></limit></axis>"));
  EXPECT_TRUE(body.find("camera")->axis_R.has_value());
}

TEST_F(PartsOfAModel, WhatNobodyReadsIsToldWithItsLine) {
  const auto warnings_of = [&](const std::string& inside) {
    std::string all;
    for (const std::string& warning : read(inside).warnings) all += warning + "\n";
    return all;
  };
  const std::string arm = "<link name='arm'>" + inertial(0.1);
  const std::string shape = "<geometry><box><size>1 1 1</size></box></geometry>";
  const std::string held =
      "</link>" +
      joint("j", "base", "arm", "<axis><limit><lower>0</lower><upper>0</upper></limit></axis>");
  EXPECT_EQ(warnings_of(kBase + arm + held), "");
  const std::pair<std::string, const char*> cases[] = {
      {arm + "<colision name='c'/>" + held,
       "model.sdf:4: <colision> in <link name='arm'> is left out: no such element"},
      {arm + "<pose>1 0 0 0 0 0</pose>\n<pose>2 0 0 0 0 0</pose>" + held,
       "model.sdf:5: a second <pose> in <link name='arm'> is left out"},
      {arm + "<pose relativ_to='base'>1 0 0 0 0 0</pose>" + held,
       "model.sdf:4: 'relativ_to' of <pose> of <link name='arm'> is left out: no such attribute"},
      {"<link name='arm'><inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy>"
       "</inertia></inertial>" +
           held,
       "link 'arm': <inertia> has no <izz>: 1 kg m^2, as SDF has it"},
      {arm + "<gravity>false</gravity>" + held, "<link name='arm'> has no <gravity> in Gazebo"},
      {arm + "<collision name='c'>" + shape +
           "<surface><contact><ode><kp>1e4</kp></ode></contact></surface></collision>" + held,
       "a <surface> of a vehicle is left out"},
      {arm +
           "<collision name='c'><geometry><box><size>1 1 1</size><sise/></box></geometry>"
           "</collision>" +
           held,
       "model.sdf:4: <sise> in <box> of <collision name='c'> is left out: no such element"},
      {arm +
           "<collision name='c'><geometry><mesh><uri>m.stl</uri><submesh><name>leg</name>"
           "</submesh></mesh></geometry></collision>" +
           held,
       "link 'arm' names a <submesh>; the whole mesh collides here"},
      {arm + held + "<plugin name='wing' filename='libLiftDragPlugin.so'/>",
       "<plugin name='wing'> acts on the model in Gazebo, and is left out here"},
      {arm + held +
           "<plugin name='m' filename='libgazebo_motor_model.so'><linkName>rotor_7</linkName>"
           "<motorConstant>1e-6</motorConstant></plugin>",
       "a motor plugin drives link 'rotor_7', which the model does not have"},
      {arm + held + joint("k", "base", "arm"),
       "joint 'k' carries link 'arm', which another joint carries: left out"},
      {arm + held + joint("k", "world", "base"), "joint 'k' holds the model to the world"},
      {arm + "</link>", "no joint holds link 'arm' to 'base': in Gazebo they fall off"}};
  for (const auto& [inside, sentence] : cases) {
    EXPECT_THAT(warnings_of(kBase + inside), HasSubstr(sentence))
        << sentence << " in " << warnings_of(kBase + inside);
  }
}

TEST_F(PartsOfAModel, AnIncludedModelIsFixedWithAllItsJoints) {
  const std::string gimbal = "<model name='gimbal'><link name='yaw'>" + inertial(0.2) +
                             "</link><model name='inner'><link name='roll'>" + inertial(0.1) +
                             "</link></model>" + joint("j", "yaw", "inner::roll") + "</model>" +
                             joint("k", "base", "gimbal::yaw");
  EXPECT_TRUE(read(kBase + gimbal).find("yaw")->axis_R.has_value());
  const ModelBody fixed = read(kBase + gimbal, {{"gimbal", PartUse::kFixed}});
  EXPECT_FALSE(fixed.find("yaw")->axis_R.has_value());
  EXPECT_FALSE(fixed.find("roll")->axis_R.has_value());
  EXPECT_NEAR(fixed.mass_kg, 1.3, kRounding);
  EXPECT_TRUE(fixed.warnings.empty());
}

TEST_F(PartsOfAModel, ASecondModelOfAFileIsTold) {
  const auto file = folder_.write("v/two.sdf", "<sdf version='1.9'><model name='a'>" + kBase +
                                                   "</model>\n<model name='b'/></sdf>");
  const ModelBody body = *read_model_body(file);
  ASSERT_EQ(body.warnings.size(), 1U);
  EXPECT_THAT(body.warnings[0], HasSubstr("two.sdf:3: <model name='b'> is left out"));
}

TEST_F(PartsOfAModel, AWorldIsNoVehicleAndItsModelIsNamed) {
  const auto file = folder_.write(
      "v/w.sdf", "<sdf version='1.9'><world name='w'><model name='iris'/></world></sdf>");
  EXPECT_THAT(
      cas::test::refusal([&] { read_model_body(file); }),
      HasSubstr("a world is no vehicle: write its <model name='iris'> to a file of its own"));
}

TEST_F(PartsOfAModel, WhatWouldMakeAnotherModelIsRefused) {
  EXPECT_THAT(refusal(kBase + "<include><uri>model://gps</uri><experimental:params/></include>"),
              HasSubstr("parameters of an <include> are not read"));
  EXPECT_THAT(refusal("<link name='base'>" + inertial(0) + "</link>"), HasSubstr("a <mass> of 0"));
}

// In the vehicle file.

/// Four propellers, and whatever else.
std::string quad(const std::string& more) {
  std::string text = "<link name='base'>" + inertial(1) + "</link>";
  const double places[4][2] = {{1, -1}, {-1, 1}, {1, 1}, {-1, -1}};
  for (int i = 0; i < 4; ++i) {
    const std::string n = std::to_string(i);
    text += "<link name='rotor_" + n + "'><pose>" + std::to_string(0.2 * places[i][0]) + " " +
            std::to_string(0.2 * places[i][1]) + " 0 0 0 0</pose>" + inertial(0.01) +
            "</link><joint name='rotor_" + n +
            "_joint' type='continuous'><parent>base</parent><child>rotor_" + n +
            "</child><axis><xyz>0 0 1</xyz></axis></joint>";
  }
  return model("q", text + more);
}

std::string motor(int rotor, const std::string& more = "") {
  return "<plugin name='m' filename='libgazebo_motor_model.so'><linkName>rotor_" +
         std::to_string(rotor) + "</linkName><turningDirection>" + (rotor < 2 ? "ccw" : "cw") +
         "</turningDirection><motorConstant>8e-06</motorConstant><momentConstant>0.02"
         "</momentConstant><maxRotVelocity>1000</maxRotVelocity><timeConstantUp>0.0125"
         "</timeConstantUp><timeConstantDown>0.025</timeConstantDown><rotorDragCoefficient>8e-05"
         "</rotorDragCoefficient><rollingMomentCoefficient>1e-06</rollingMomentCoefficient>" +
         more + "</plugin>\n";
}

constexpr const char* kYaml = R"(schema: 1
name: q
sdf: q.sdf
body_drag_linear_n_s_m: 0
system_id: 1
rotor: {omega_idle_rad_s: 0, inertia_kg_m2: 3.0e-5, radius_m: 0.1, zero_thrust_speed_m_s: 0,
  reference_density_kg_m3: 0, ground_effect: 0}
)";

TEST(VehicleOfParts, MotorPluginsGiveWhatTheFileDoesNotHaveAndItIsSaid) {
  const cas::test::TemporaryFolder folder;
  folder.write("q.sdf",
               quad(motor(0) + motor(1) + motor(2) + motor(3, "<reversible>1</reversible>")));
  const Vehicle vehicle = Vehicle::load(folder.write(
      "q.yaml", std::string(kYaml) + "rotors: [{thrust_coefficient: 9.0e-6}, {}, {}, {}]\n"));
  EXPECT_EQ(vehicle.rotors[0].params.thrust_coefficient, 9e-6) << "the file's own";
  EXPECT_EQ(vehicle.rotors[1].params.thrust_coefficient, 8e-6);
  EXPECT_NEAR(vehicle.rotors[1].params.torque_coefficient, 1.6e-7, kRounding);
  EXPECT_EQ(vehicle.rotors[2].params.omega_max_rad_s, 1000);
  EXPECT_EQ(vehicle.rotors[0].spin, 1);
  EXPECT_EQ(vehicle.rotors[3].spin, -1);
  EXPECT_FALSE(vehicle.rotors[2].params.reversible);
  EXPECT_TRUE(vehicle.rotors[3].params.reversible);
  ASSERT_EQ(vehicle.warnings.size(), 3U) << "one for each set of keys";
  for (const std::string& warning : vehicle.warnings) {
    EXPECT_THAT(warning, HasSubstr("the model's motor plugin gives spin, "));
  }
}

TEST(VehicleOfParts, AReversibleRotorStandsAtZero) {
  const cas::test::TemporaryFolder folder;
  std::string text = kYaml;
  text.replace(text.find("omega_idle_rad_s: 0"), 19, "omega_idle_rad_s: 9");
  folder.write("q.sdf", quad(motor(0) + motor(1) + motor(2) + motor(3)));
  const auto file = folder.write("q.yaml", text + "rotors: [{reversible: true}, {}, {}, {}]\n");
  EXPECT_THAT(cas::test::refusal([&] { Vehicle::load(file); }),
              HasSubstr("omega_idle_rad_s: must be 0"));
}

/// A link that turns without end: a gimbal, or a propeller that the list forgot.
std::string turning_link(const std::string& name, double mass) {
  return "<link name='" + name + "'>" + inertial(mass) + "</link><joint name='" + name +
         "_joint' type='revolute'><parent>base</parent><child>" + name + "</child></joint>";
}

TEST(VehicleOfParts, AGimbalIsFixedWithAWarningUnlessTheFileSaysSo) {
  const cas::test::TemporaryFolder folder;
  folder.write("q.sdf",
               quad(motor(0) + motor(1) + motor(2) + motor(3) + turning_link("gimbal", 0.3)));
  const std::string yaml = std::string(kYaml) + "rotors: [{}, {}, {}, {}]\n";
  const Vehicle vehicle = Vehicle::load(folder.write("q.yaml", yaml));
  EXPECT_NEAR(vehicle.mass_kg, 1.34, kRounding);
  EXPECT_EQ(vehicle.parts.at("gimbal"), PartUse::kFixed);
  EXPECT_THAT(vehicle.warnings.back(), HasSubstr("`parts: {gimbal: fixed}`"));
  const std::size_t warnings = vehicle.warnings.size();
  const Vehicle said = Vehicle::load(folder.write("q.yaml", yaml + "parts: {gimbal: fixed}\n"));
  EXPECT_EQ(said.warnings.size(), warnings - 1);
  EXPECT_NEAR(Vehicle::load(folder.write("q.yaml", yaml + "parts: {gimbal: left_out}\n")).mass_kg,
              1.04, kRounding);
}

TEST(VehicleOfParts, APropellerThatTheListForgetsIsRefused) {
  const cas::test::TemporaryFolder folder;
  folder.write("q.sdf",
               quad(motor(0) + motor(1) + motor(2) + motor(3) + turning_link("prop", 0.01)));
  const auto file = folder.write("q.yaml", std::string(kYaml) + "rotors: [{}, {}, {}, {}]\n");
  const std::string text = cas::test::refusal([&] { Vehicle::load(file); });
  EXPECT_THAT(text, HasSubstr("has one more: link 'prop'"));
  EXPECT_THAT(text, HasSubstr("`parts: {prop: fixed}`"));
}

}  // namespace
}  // namespace cas::base
