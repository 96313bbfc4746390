// SPDX-License-Identifier: BSD-3-Clause
// Requests of pilots, companions and missions, in closed loop.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/earth/frames.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/mission_ack.hpp"
#include "mavlink/common/mission_count.hpp"
#include "mavlink/common/mission_item_int.hpp"
#include "mavlink/common/mission_item_reached.hpp"
#include "mavlink/common/mission_request_int.hpp"
#include "mavlink/common/set_attitude_target.hpp"
#include "mavlink/common/set_position_target_local_ned.hpp"
#include "tests/fcu/support/closed_loop.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::ClosedLoop;
using test::LoopOptions;
using test::rtk_noise;

class Modes : public testing::Test {
 protected:
  static LoopOptions options() {
    LoopOptions o;
    o.noise = rtk_noise();
    return o;
  }
  void hover() {
    ASSERT_TRUE(loop_.fly_to_hover(2.5));
    loop_.go_to(0, 0, 2.5, 0.0F);
    loop_.run(6);
  }
  /// Repeats a message at 20 Hz.
  template <class Message>
  void stream(const Message& message, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 20); ++i) {
      loop_.send(message);
      loop_.run(0.05);
    }
  }
  bool near(double n, double e, double u, double within) const {
    return (loop_.truth().p_N - Eigen::Vector3d(n, e, -u)).norm() < within;
  }
  ClosedLoop loop_{options()};
};

SetPositionTargetLocalNed position(float x, float y, float z, float yaw) {
  using M = PositionTargetTypemask;
  SetPositionTargetLocalNed m{.target_system = 1, .coordinate_frame = MavFrame::kLocalNed};
  m.type_mask = M::kVxIgnore | M::kVyIgnore | M::kVzIgnore | M::kAxIgnore | M::kAyIgnore |
                M::kAzIgnore | M::kYawRateIgnore;
  m.x = x;
  m.y = y;
  m.z = z;
  m.yaw = yaw;
  return m;
}

/// casd restores the parameter that it has written for a takeoff once the vehicle climbs.
TEST_F(Modes, ATakeoffKeepsTheHeightThatItsParameterHadAtTheBeginning) {
  ASSERT_TRUE(loop_.run_until([&] { return loop_.fcu().status().estimator_ready; }, 20));
  EXPECT_TRUE(loop_.fcu().set_param("MIS_TAKEOFF_ALT", 6));
  ASSERT_TRUE(loop_.arm());
  EXPECT_EQ(loop_.command(MavCmd::kNavTakeoff, {0, 0, 0, NAN, NAN, NAN, NAN}),
            MavResult::kAccepted);
  loop_.run(3);
  EXPECT_TRUE(loop_.fcu().set_param("MIS_TAKEOFF_ALT", 2.5));
  loop_.run(15);
  EXPECT_TRUE(near(0, 0, 6, 0.5)) << loop_.truth().p_N.transpose();
}

TEST_F(Modes, OffboardFollowsPositionAndYaw) {
  hover();
  loop_.send(position(2, 1, -3, 0.8F));
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kAccepted);
  stream(position(2, 1, -3, 0.8F), 8);
  EXPECT_TRUE(near(2, 1, 3, 0.1));
  EXPECT_NEAR(loop_.yaw(), 0.8, 0.05);
}

TEST_F(Modes, OffboardIsRefusedWithoutSetPoints) {
  hover();
  EXPECT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kTemporarilyRejected);
}

TEST_F(Modes, OffboardTakesOffAndFollowsVelocity) {
  ASSERT_TRUE(loop_.run_until([&] { return loop_.fcu().status().estimator_ready; }, 20));
  loop_.send(position(0, 0, -2, 0));
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kAccepted);
  ASSERT_TRUE(loop_.arm());
  stream(position(0, 0, -2, 0), 8);
  EXPECT_TRUE(near(0, 0, 2, 0.15));
  using M = PositionTargetTypemask;
  SetPositionTargetLocalNed velocity = position(0, 0, 0, 0);
  velocity.type_mask = M::kXIgnore | M::kYIgnore | M::kZIgnore | M::kAxIgnore | M::kAyIgnore |
                       M::kAzIgnore | M::kYawRateIgnore;
  velocity.vx = 1;
  stream(velocity, 5);
  EXPECT_NEAR(loop_.truth().v_N.x(), 1, 0.1);
}

TEST_F(Modes, OffboardFollowsAttitude) {
  hover();
  SetAttitudeTarget target{
      .target_system = 1,
      .q = {static_cast<float>(std::cos(0.05)), static_cast<float>(std::sin(0.05)), 0, 0},
      .thrust = 0.54F};
  loop_.send(target);
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kAccepted);
  stream(target, 1);
  EXPECT_NEAR(base::euler_rpy(loop_.truth().q_ND).x(), 0.1, 0.03);
}

TEST_F(Modes, OffboardLeavesOutWhatIsNoNumber) {
  hover();
  SetAttitudeTarget target{
      .target_system = 1, .q = {std::numeric_limits<float>::infinity(), 0, 0, 0}, .thrust = 0.54F};
  loop_.send(target);
  EXPECT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kTemporarilyRejected);
  target.q = {1, 0, 0, 0};
  target.thrust = std::numeric_limits<float>::quiet_NaN();
  loop_.send(target);
  EXPECT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kTemporarilyRejected);
  target.thrust = 0.54F;
  target.body_yaw_rate = std::numeric_limits<float>::quiet_NaN();
  loop_.send(target);
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 6, 0}), MavResult::kAccepted);
  stream(target, 1);
  EXPECT_LT(base::euler_rpy(loop_.truth().q_ND).head<2>().norm(), 0.1);
}

TEST_F(Modes, PositionModeFliesBySticksAndHoldsWhenTheyAreCentred) {
  hover();
  ManualControl sticks{.target = 1, .z = 500};
  loop_.send(sticks);
  ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, 3, 0}), MavResult::kAccepted);
  sticks.x = 500;
  stream(sticks, 4);
  EXPECT_GT(loop_.truth().v_N.x(), 1.0);
  sticks.x = 0;
  stream(sticks, 5);
  EXPECT_LT(loop_.truth().v_N.norm(), 0.1);
  const double yaw = loop_.yaw();
  sticks.r = 500;
  stream(sticks, 1);
  EXPECT_GT(loop_.yaw(), yaw + 0.5);
}

TEST_F(Modes, AltitudeAndStabilizedModesTiltBySticks) {
  hover();
  for (const float main_mode : {2.0F, 7.0F}) {
    ManualControl sticks{.target = 1, .z = 500};
    loop_.send(sticks);
    ASSERT_EQ(loop_.command(MavCmd::kDoSetMode, {1, main_mode, 0}), MavResult::kAccepted);
    sticks.y = 300;
    stream(sticks, 1);
    EXPECT_NEAR(base::euler_rpy(loop_.truth().q_ND).x(), 0.3 * 35 * M_PI / 180, 0.06);
    sticks.y = -300;
    stream(sticks, 1);
  }
}

TEST_F(Modes, ReturnComesHomeAndLands) {
  hover();
  loop_.go_to(10, 5, 3);
  loop_.run(10);
  ASSERT_EQ(loop_.command(MavCmd::kNavReturnToLaunch), MavResult::kAccepted);
  EXPECT_TRUE(loop_.run_until([&] { return !loop_.fcu().status().armed; }, 90));
  EXPECT_TRUE(near(0, 0, 0, 0.5));
}

TEST_F(Modes, TerminationStopsTheRotorsForGood) {
  hover();
  EXPECT_EQ(loop_.command(MavCmd::kDoFlighttermination, {NAN}), MavResult::kDenied);
  EXPECT_TRUE(loop_.fcu().status().armed) << "no number is no order";
  EXPECT_EQ(loop_.command(MavCmd::kDoFlighttermination, {1}), MavResult::kAccepted);
  EXPECT_FALSE(loop_.fcu().status().armed);
  EXPECT_FALSE(loop_.arm());
}

// Missions.

MissionItemInt item(std::uint16_t seq, MavCmd command, double north, double east, float up,
                    const base::Geodetic& home) {
  const base::Geodetic place = base::LocalProjection(home).to_geodetic({north, east, 0});
  MissionItemInt m{.target_system = 1,
                   .target_component = 1,
                   .seq = seq,
                   .frame = MavFrame::kGlobalRelativeAltInt,
                   .command = command,
                   .autocontinue = 1,
                   .x = static_cast<std::int32_t>(std::llround(place.lat_deg * 1e7)),
                   .y = static_cast<std::int32_t>(std::llround(place.lon_deg * 1e7)),
                   .z = up};
  return m;
}

TEST_F(Modes, MissionIsUploadedFlownAndLanded) {
  ASSERT_TRUE(loop_.run_until([&] { return loop_.fcu().status().estimator_ready; }, 20));
  const MissionItemInt items[] = {item(0, MavCmd::kNavTakeoff, 0, 0, 3, loop_.home()),
                                  item(1, MavCmd::kNavWaypoint, 8, 0, 3, loop_.home()),
                                  item(2, MavCmd::kNavWaypoint, 8, 6, 4, loop_.home()),
                                  item(3, MavCmd::kNavLand, 0, 6, 0, loop_.home())};
  loop_.send(MissionCount{.target_system = 1, .target_component = 1, .count = 4});
  for (const MissionItemInt& m : items) {
    ASSERT_FALSE(loop_.received<MissionRequestInt>().empty());
    EXPECT_EQ(loop_.received<MissionRequestInt>().back().seq, m.seq);
    loop_.send(m);
  }
  ASSERT_FALSE(loop_.received<MissionAck>().empty());
  EXPECT_EQ(loop_.received<MissionAck>().back().type, MavMissionResult::kAccepted);

  ASSERT_TRUE(loop_.arm());
  ASSERT_EQ(loop_.command(MavCmd::kMissionStart), MavResult::kAccepted);
  EXPECT_TRUE(loop_.run_until([&] { return !loop_.fcu().status().armed; }, 120));
  EXPECT_TRUE(near(0, 6, 0, 0.5));
  EXPECT_EQ(loop_.received<MissionItemReached>().size(), 4U);
}

TEST_F(Modes, MissionRequestIsRepeatedUntilTheItemComes) {
  loop_.run(1);
  loop_.send(MissionCount{.target_system = 1, .count = 1});
  loop_.run(1);
  EXPECT_GE(loop_.received<MissionRequestInt>().size(), 3U);
  loop_.run(4);
  EXPECT_EQ(loop_.received<MissionAck>().back().type, MavMissionResult::kOperationCancelled);
}

}  // namespace
}  // namespace cas::fcu
