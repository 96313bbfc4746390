// SPDX-License-Identifier: BSD-3-Clause
// The shipped airframes as stock firmware expects them: rotor order, spins, signs of the moments
// and the output at which they hover. Firmware notices a wrong sign by falling; these tests sooner.
#include <gtest/gtest.h>

#include "plugins/motor/motor_mixer.hpp"
#include "tests/plugins/plugin_harness.hpp"

namespace cas::sim {
namespace {

struct QuadCase {
  const char* name;
  double hover_output;
};

class QuadX : public testing::TestWithParam<QuadCase> {
 protected:
  /// Thrust and moments (U1..U4 in the axes of D) at these outputs.
  Eigen::Vector4d inputs(const Eigen::Vector4d& outputs) const {
    MotorCommand command;
    command.kind = MotorCommand::Kind::kMotorOutputs;
    command.armed = true;
    command.values = outputs;
    const Eigen::Vector4d omega = MotorMixer(vehicle_).targets(command);
    return vehicle_.mixing_matrix() * omega.cwiseAbs2();
  }

  base::Vehicle vehicle_ = test::load_vehicle(GetParam().name);
};

TEST_P(QuadX, RotorsAreFrontRightRearLeftFrontLeftRearRight) {
  const auto& r = vehicle_.rotors;
  const auto forward = [&](std::size_t i) { return r[i].position_B_m.x() > 0; };
  const auto left = [&](std::size_t i) { return r[i].position_B_m.y() > 0; };
  EXPECT_TRUE(forward(0) && !left(0));
  EXPECT_TRUE(!forward(1) && left(1));
  EXPECT_TRUE(forward(2) && left(2));
  EXPECT_TRUE(!forward(3) && !left(3));
  EXPECT_EQ(r[0].spin, 1) << "counter-clockwise";
  EXPECT_EQ(r[1].spin, 1);
  EXPECT_EQ(r[2].spin, -1);
  EXPECT_EQ(r[3].spin, -1);
}

TEST_P(QuadX, HoversAtTheOutputThatTheFileSays) {
  const double hover = GetParam().hover_output;
  const Eigen::Vector4d u = inputs(Eigen::Vector4d::Constant(hover));
  EXPECT_NEAR(u[0] / (vehicle_.mass_kg * test::kGravity), 1, 0.02);
}

TEST_P(QuadX, MomentsHaveTheSignsOfForwardRightDown) {
  const Eigen::Vector4d hover = Eigen::Vector4d::Constant(GetParam().hover_output);
  const auto moment = [&](const Eigen::Vector4d& change) {
    return (inputs(hover + 0.05 * change) - inputs(hover)).tail<3>().eval();
  };
  EXPECT_GT(moment({-1, 1, 1, -1}).x(), 0) << "left rotors up roll to the right";
  EXPECT_GT(moment({1, -1, 1, -1}).y(), 0) << "front rotors up pitch the nose up";
  EXPECT_GT(moment({1, 1, -1, -1}).z(), 0) << "counter-clockwise rotors up turn clockwise";
}

INSTANTIATE_TEST_SUITE_P(Shipped, QuadX,
                         testing::Values(QuadCase{"iris_px4", 0.703}, QuadCase{"x500", 0.729},
                                         QuadCase{"quad_x", 0.494}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace cas::sim
