// SPDX-License-Identifier: BSD-3-Clause
// Events in flight: radio sticks and their loss, built-in trajectories, gains that change, samples
// stamped by their arrival.
#include <gtest/gtest.h>

#include "mavlink/common/hil_rc_inputs_raw.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "tests/fcu/support/closed_loop.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::ClosedLoop;
using test::LoopOptions;

LoopOptions rtk() {
  LoopOptions options;
  options.noise = test::rtk_noise();
  return options;
}

class InFlight : public testing::Test {
 protected:
  void hover() {
    ASSERT_TRUE(loop_.fly_to_hover(2.5));
    loop_.go_to(0, 0, 2.5, 0.0F);
    loop_.run(6);
  }
  double off(double north, double east, double up) const {
    return (loop_.truth().p_N - Eigen::Vector3d(north, east, -up)).norm();
  }
  ClosedLoop loop_{rtk()};
};

TEST_F(InFlight, RadioChannelsFlyAndTheirLossIsAFailsafe) {
  hover();
  HilRcInputsRaw radio;
  radio.chan1_raw = radio.chan2_raw = radio.chan3_raw = radio.chan4_raw = 1500;
  const auto stream = [&](double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 50); ++i) {
      loop_.send(radio);
      loop_.run(0.02);
    }
  };
  stream(0.1);
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 3, 0}), MavResult::kAccepted);  // POSCTL
  radio.chan2_raw = 1250;  // stick forward is nose down
  stream(4);
  EXPECT_GT(loop_.truth().v_N.x(), 1);
  radio.chan2_raw = 1500;
  stream(4);
  EXPECT_LT(loop_.truth().v_N.norm(), 0.1);
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 7, 0}), MavResult::kAccepted);  // STABILIZED
  stream(0.5);
  EXPECT_TRUE(loop_.run_until([&] { return loop_.fcu().status().mode == FlightMode::kReturn; }, 2));
  EXPECT_TRUE(loop_.said("Manual control lost"));
}

TEST_F(InFlight, OrbitKeepsItsRadiusAndSpeed) {
  hover();
  ASSERT_EQ(loop_.command(MavCmd::kDoOrbit, {4, 2}), MavResult::kAccepted);
  loop_.run(10);
  double nearest = 1e9, farthest = 0, fastest = 0;
  loop_.run(14, [&] {
    const double radius = loop_.truth().p_N.head<2>().norm();
    nearest = std::min(nearest, radius);
    farthest = std::max(farthest, radius);
    fastest = std::max(fastest, loop_.truth().v_N.norm());
  });
  EXPECT_GT(nearest, 3.85);
  EXPECT_LT(farthest, 4.15);
  EXPECT_NEAR(fastest, 2, 0.2);
}

TEST_F(InFlight, TheBuiltInCircleBeginsAndEndsByParameter) {
  hover();
  ASSERT_TRUE(loop_.fcu().set_param("CAS_TRJ_SIZE", 3));
  ASSERT_TRUE(loop_.fcu().set_param("CAS_TRJ_SPEED", 1.5));
  ASSERT_TRUE(loop_.fcu().set_param("CAS_TRJ_SHAPE", 1));
  loop_.run(12);
  EXPECT_NEAR(loop_.truth().p_N.head<2>().norm(), 3, 0.15);
  EXPECT_NEAR(loop_.truth().v_N.norm(), 1.5, 0.2);
  ASSERT_TRUE(loop_.fcu().set_param("CAS_TRJ_SHAPE", 0));
  loop_.run(8);
  EXPECT_LT(loop_.truth().v_N.norm(), 0.1);
}

TEST_F(InFlight, GainsChangeWithoutABump) {
  hover();
  const auto set = [&](const char* name, float value) {
    ParamSet m{.target_system = 1, .target_component = 1};
    mav::set_text(m.param_id, name);
    m.param_value = value;
    m.param_type = MavParamType::kReal32;
    loop_.send(m);
  };
  double worst = 0;
  for (int i = 0; i < 8; ++i) {
    const bool soft = i % 2 == 0;
    set("MPC_XY_VEL_I_ACC", soft ? 0.3F : 0.9F);
    set("MPC_Z_VEL_I_ACC", soft ? 1.0F : 3.0F);
    set("MC_ROLLRATE_I", soft ? 0.1F : 0.5F);
    set("MPC_XY_P", soft ? 1.2F : 1.6F);
    loop_.run(1, [&] { worst = std::max(worst, off(0, 0, 2.5)); });
  }
  EXPECT_LT(worst, 0.1);
}

/// As PX4 takes them in HITL: the line's delay and jitter become the estimator's.
TEST(Stamps, ByArrivalItStillFlies) {
  LoopOptions options = rtk();
  options.line = LineConfig::from_preset("baud_921600");
  options.configure = [](FcuConfig& config) { config.stamp = StampMode::kArrival; };
  ClosedLoop loop(options);
  ASSERT_TRUE(loop.fly_to_hover(2.5));
  loop.go_to(0, 0, 2.5, 0.0F);
  loop.run(8);
  double worst = 0;
  loop.run(20, [&] {
    worst = std::max(worst, (loop.truth().p_N - Eigen::Vector3d(0, 0, -2.5)).norm());
  });
  EXPECT_LT(worst, 0.15);
}

}  // namespace
}  // namespace cas::fcu
