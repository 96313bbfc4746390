// SPDX-License-Identifier: BSD-3-Clause
// Airframes other than the quadrotor of [HILS], flown with the noise of its Table 1 by a simulator
// that shares no code with libsim.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>

#include "base/earth/frames.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "tests/fcu/support/closed_loop.hpp"
#include "tests/fcu/support/frames.hpp"

namespace cas::fcu {
namespace {

using mavlink::common::Heartbeat;
using mavlink::common::ServoOutputRaw;
using test::ClosedLoop;

struct Frame {
  const char* name;
  std::function<base::Vehicle()> vehicle;
  int type;     ///< MAV_TYPE
  int outputs;  ///< in use
};

test::LoopOptions options_of(const base::Vehicle& vehicle) {
  test::LoopOptions options;
  options.airframe = vehicle;
  return options;
}

/// The largest deviation of the truth from a place, and tilt, over a stretch of flight.
struct Worst {
  double horizontal_m = 0;
  double vertical_m = 0;
  double tilt_rad = 0;
  double yaw_rad = 0;
  double yaw_rate_rad_s = 0;

  void add(ClosedLoop& loop, double north_m, double east_m, double up_m) {
    const auto& truth = loop.truth();
    horizontal_m =
        std::max(horizontal_m, std::hypot(truth.p_N.x() - north_m, truth.p_N.y() - east_m));
    vertical_m = std::max(vertical_m, std::abs(truth.p_N.z() + up_m));
    tilt_rad = std::max(tilt_rad, std::acos((truth.q_ND * Eigen::Vector3d::UnitZ()).z()));
    yaw_rad = std::max(yaw_rad, std::abs(loop.yaw()));
    yaw_rate_rad_s = std::max(yaw_rate_rad_s, std::abs(truth.w_D.z()));
  }
};

Worst watch(ClosedLoop& loop, double seconds, double north_m, double east_m, double up_m) {
  Worst worst;
  loop.run(seconds, [&] { worst.add(loop, north_m, east_m, up_m); });
  return worst;
}

class FrameFlight : public testing::TestWithParam<Frame> {
 protected:
  FrameFlight() : loop_(options_of(GetParam().vehicle())) {}
  ClosedLoop loop_;
};

TEST_P(FrameFlight, HoversStepsAndStandsAgainstWind) {
  ASSERT_TRUE(loop_.fly_to_hover(3));
  loop_.run(5);
  const Worst hover = watch(loop_, 10, 0, 0, 3);
  EXPECT_LT(hover.horizontal_m, 0.6);
  EXPECT_LT(hover.vertical_m, 0.4);
  EXPECT_LT(hover.yaw_rad, 0.1);

  loop_.go_to(4, -2, 5);
  loop_.run(8);
  const Worst step = watch(loop_, 5, 4, -2, 5);
  EXPECT_LT(step.horizontal_m, 0.6);
  EXPECT_LT(step.vertical_m, 0.4);
  EXPECT_LT(step.yaw_rad, 0.1);

  loop_.multirotor().set_wind({0, 8, 0});
  loop_.run(8);
  const Worst wind = watch(loop_, 10, 4, -2, 5);
  EXPECT_LT(wind.horizontal_m, 0.6);
  EXPECT_LT(wind.vertical_m, 0.4);
  EXPECT_LT(wind.yaw_rad, 0.1);
  EXPECT_FALSE(loop_.said("lost")) << "no rotor is";

  // Feet cannot slide here, and leaning rotors push against them; hexa_tilt lands in its scenario.
  if (std::string(GetParam().name) == "TiltedHexa") return;
  loop_.command(mavlink::common::MavCmd::kNavLand);
  EXPECT_TRUE(loop_.run_until([this] { return !loop_.fcu().status().armed; }, 30));
}

TEST_P(FrameFlight, TellsWhatItIsAndAllItsOutputs) {
  ASSERT_TRUE(loop_.fly_to_hover(3));
  loop_.run(2);
  ASSERT_FALSE(loop_.received<Heartbeat>().empty());
  EXPECT_EQ(static_cast<int>(loop_.received<Heartbeat>().back().type), GetParam().type);
  ASSERT_FALSE(loop_.received<ServoOutputRaw>().empty());
  const ServoOutputRaw m = loop_.received<ServoOutputRaw>().back();
  const std::uint16_t pulses[] = {m.servo1_raw, m.servo2_raw, m.servo3_raw,
                                  m.servo4_raw, m.servo5_raw, m.servo6_raw,
                                  m.servo7_raw, m.servo8_raw, m.servo9_raw};
  for (int i = 0; i < 9; ++i) {
    if (i < GetParam().outputs) {
      EXPECT_GT(pulses[i], 1100) << i;
      EXPECT_LT(pulses[i], 1900) << i;
    } else {
      EXPECT_EQ(pulses[i], 0) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, FrameFlight,
    testing::Values(Frame{"Hexa", test::hexa_x, 13, 6}, Frame{"Octo", test::octo_x, 14, 8},
                    Frame{"Y6", test::y6, 13, 6}, Frame{"X8", test::x8, 14, 8},
                    Frame{"Tri", test::tri, 15, 4},
                    Frame{"TiltedHexa", [] { return test::tilted_hexa(0.35); }, 13, 6}),
    [](const auto& test) { return test.param.name; });

TEST(TiltedHexa, HoldsItsPlaceInWindWithoutLeaning) {
  const auto lean = [](const base::Vehicle& vehicle) {
    ClosedLoop loop(options_of(vehicle));
    EXPECT_TRUE(loop.fly_to_hover(3));
    loop.multirotor().set_wind({2, 0, 0});
    loop.run(10);
    double sum = 0;
    int count = 0;
    loop.run(5, [&] {
      sum += base::euler_rpy(loop.truth().q_ND).y();
      ++count;
    });
    EXPECT_LT(loop.truth().p_N.head<2>().norm(), 0.6);
    return std::abs(sum / count);
  };
  EXPECT_GT(lean(test::hexa_x()), 0.05);
  EXPECT_LT(lean(test::tilted_hexa(0.35)), 0.015);
}

// A rotor stops in flight.

class LostInFlight : public testing::TestWithParam<int> {};

TEST_P(LostInFlight, AHexaFindsTheLostRotorAndFliesOn) {
  ClosedLoop loop(options_of(test::hexa_x()));
  ASSERT_TRUE(loop.fly_to_hover(10));
  loop.run(5);
  loop.multirotor().weaken_rotor(GetParam(), 0);
  const std::string text = "Rotor " + std::to_string(GetParam() + 1) + " lost: flying on";
  EXPECT_TRUE(loop.run_until([&] { return loop.said(text); }, 1.0));
  const Worst caught = watch(loop, 10, 0, 0, 10);
  EXPECT_LT(caught.horizontal_m, 3);
  EXPECT_LT(caught.vertical_m, 2);
  const Worst after = watch(loop, 10, 0, 0, 10);
  EXPECT_LT(after.horizontal_m, 1);
  EXPECT_LT(after.vertical_m, 0.5);
  EXPECT_LT(after.tilt_rad, 0.3);
  EXPECT_TRUE(loop.said("Heading given up"));
  EXPECT_LT(after.yaw_rate_rad_s, 0.5) << "turning is damped";
  loop.command(mavlink::common::MavCmd::kNavLand);
  EXPECT_TRUE(loop.run_until([&] { return !loop.fcu().status().armed; }, 60));
}

INSTANTIATE_TEST_SUITE_P(Each, LostInFlight, testing::Range(0, 6));

struct Loss {
  const char* name;
  std::function<base::Vehicle()> vehicle;
};

class LostElsewhere : public testing::TestWithParam<Loss> {};

TEST_P(LostElsewhere, TheHeadingIsKept) {
  const base::Vehicle vehicle = GetParam().vehicle();
  for (const int lost : {0, 3}) {
    ClosedLoop loop(options_of(vehicle));
    ASSERT_TRUE(loop.fly_to_hover(10));
    loop.run(5);
    loop.multirotor().weaken_rotor(lost, 0);
    const std::string text = "Rotor " + std::to_string(lost + 1) + " lost: flying on";
    EXPECT_TRUE(loop.run_until([&] { return loop.said(text); }, 1.5)) << lost;
    loop.run(10);
    const Worst after = watch(loop, 10, 0, 0, 10);
    EXPECT_LT(after.horizontal_m, 0.6);
    EXPECT_LT(after.vertical_m, 0.4);
    EXPECT_LT(after.yaw_rad, 0.15);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LostElsewhere,
                         testing::Values(Loss{"Octo", test::octo_x}, Loss{"X8", test::x8}),
                         [](const auto& test) { return test.param.name; });

class LostOfTilted : public testing::TestWithParam<int> {};

/// On five tilted rotors it yaws a little to one side and far to the other: it turns back slowly.
TEST_P(LostOfTilted, TheHeadingIsTakenUpAgain) {
  test::LoopOptions options;
  options.vehicle = "hexa_tilt";
  ClosedLoop loop(options);
  ASSERT_TRUE(loop.fly_to_hover(10));
  loop.run(5);
  loop.multirotor().weaken_rotor(GetParam(), 0);
  const std::string text = "Rotor " + std::to_string(GetParam() + 1) + " lost: flying on";
  EXPECT_TRUE(loop.run_until([&] { return loop.said(text); }, 1.5));
  EXPECT_FALSE(loop.said("Heading given up"));
  loop.run(30);
  const Worst after = watch(loop, 10, 0, 0, 10);
  EXPECT_LT(after.horizontal_m, 1);
  EXPECT_LT(after.vertical_m, 0.5);
  EXPECT_LT(after.tilt_rad, 0.5);
  EXPECT_LT(after.yaw_rad, 0.15);
}

INSTANTIATE_TEST_SUITE_P(Each, LostOfTilted, testing::Range(0, 6));

TEST(LostRotor, IsLeftOutWhenTheParameterSaysSo) {
  test::LoopOptions options = options_of(test::hexa_x());
  options.configure = [](FcuConfig& config) { config.params.emplace_back("CAS_ROT_DETECT", 0); };
  ClosedLoop loop(options);
  ASSERT_TRUE(loop.fly_to_hover(10));
  loop.run(3);
  loop.multirotor().weaken_rotor(1, 0);
  EXPECT_TRUE(loop.fcu().set_param("CAS_ROT_LOST", 0b10));
  const Worst caught = watch(loop, 15, 0, 0, 10);
  EXPECT_FALSE(loop.said("lost"));
  EXPECT_LT(caught.horizontal_m, 3);
  EXPECT_LT(caught.vertical_m, 2);
  EXPECT_TRUE(loop.fcu().set_param("CAS_ROT_LOST", 0b110));  // two neighbours: it cannot be
  loop.run(1);
  EXPECT_TRUE(loop.said("cannot carry"));
}

/// A weak rotor or a disturbance is no loss.
TEST(LostRotor, IsNotSeenInAWeakOneNorInAGust) {
  ClosedLoop loop(options_of(test::hexa_x()));
  ASSERT_TRUE(loop.fly_to_hover(10));
  loop.run(3);
  loop.multirotor().weaken_rotor(2, 0.6);
  loop.run(5);
  loop.multirotor().weaken_rotor(2, 1);
  loop.multirotor().set_wind({8, 0, 0});
  loop.run(3);
  loop.go_to(10, 10, 6, 2);
  loop.run(10);
  EXPECT_FALSE(loop.said("lost"));
}

}  // namespace
}  // namespace cas::fcu
