// SPDX-License-Identifier: BSD-3-Clause
// What a controller at hilsim's link gets of a vehicle's odometry.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/angles.hpp"
#include "mavlink/common/odometry.hpp"
#include "mavlink/common/vision_position_estimate.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

namespace mv = mavlink::common;

/// Half a second of a vehicle that stands 3 m north and 2 m east of the origin, its nose to the
/// east.
class OdometryLink : public testing::Test {
 protected:
  void run(const std::string& keys) {
    const std::string text =
        "schema: 1\nworld: {gravity_m_s2: 9.80665, ground: true}\n"
        "home: {lat_deg: 47.4, lon_deg: 8.5, alt_m: 488}\ndecimal_year: 2026.5\npace: free_run\n"
        "vehicles:\n  - name: iris0\n    vehicle: " +
        source_dir() +
        "/config/vehicles/iris_px4.yaml\n    pose: {x_m: 2, y_m: 3, yaw_deg: 0}\n    plugins:\n"
        "      - {plugin: motor}\n      - {plugin: imu}\n"
        "      - {plugin: odometry, rate_hz: 20, delay_s: 0.03, position_stddev_m: 0.001, "
        "attitude_stddev_deg: 0.01, velocity_stddev_m_s: 0.002, rate_stddev_deg_s: 0.02, " +
        keys +
        "}\n      - {plugin: mavlink_interface, transport: udp, local: \"127.0.0.1:0\", "
        "remote: \"" +
        peer_.endpoint() + "\"}\n";
    ChildProcess hilsim({binary_dir() + "/bin/hilsim", folder_.write("sim.yaml", text).string(),
                         "--duration", "0.5"});
    EXPECT_EQ(hilsim.wait_exit(), 0) << hilsim.output();
    peer_.read(stream_);
  }

  template <class Message>
  std::vector<Message> all() {
    std::vector<Message> found;
    for (const auto& packet : stream_.packets()) {
      if (const auto message = mav::decode<Message>(packet.view())) found.push_back(*message);
    }
    return found;
  }

 private:
  TemporaryFolder folder_;
  UdpPeer peer_;
  PacketStream stream_;
};

constexpr double kFiveDeviations_m = 0.005;
constexpr double kFiveDeviations_rad = 0.001;

double at(float value) { return static_cast<double>(value); }

TEST_F(OdometryLink, CarriesOdometryInItsFrame) {
  run("heading_deg: 90, origin_N_m: [1, 0, 0], frame: LOCAL_FRD, estimator_type: VISION, quality: "
      "60");
  const auto messages = all<mv::Odometry>();
  ASSERT_EQ(messages.size(), 9U);  // of 0.05 s to 0.45 s: the last one of 0.5 s is on its way
  EXPECT_TRUE(all<mv::VisionPositionEstimate>().empty());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const mv::Odometry& m = messages[i];
    EXPECT_EQ(m.time_usec, 50'000 * (i + 1));
    EXPECT_EQ(m.frame_id, mv::MavFrame::kLocalFrd);
    EXPECT_EQ(m.child_frame_id, mv::MavFrame::kBodyFrd);
    EXPECT_EQ(m.estimator_type, mv::MavEstimatorType::kVision);
    EXPECT_EQ(m.quality, 60);
    EXPECT_EQ(m.reset_counter, 0);
    EXPECT_NEAR(at(m.x), 2, kFiveDeviations_m) << "east is ahead";
    EXPECT_NEAR(at(m.y), -2, kFiveDeviations_m) << "north is to the left";
    EXPECT_LT(at(m.z), 0) << "its centre is above the ground";
    EXPECT_NEAR(std::abs(at(m.q[0])), 1, kFiveDeviations_rad) << "along the frame's own heading";
    EXPECT_NEAR(at(m.yawspeed), 0, 0.01);
    EXPECT_NEAR(at(m.pose_covariance[0]), 1e-6, 1e-9);
    EXPECT_NEAR(at(m.velocity_covariance[0]), 4e-6, 1e-9);
  }
}

TEST_F(OdometryLink, CarriesVisionPositionEstimate) {
  run("message: VISION_POSITION_ESTIMATE");
  const auto messages = all<mv::VisionPositionEstimate>();
  ASSERT_EQ(messages.size(), 9U);
  EXPECT_TRUE(all<mv::Odometry>().empty());
  for (const mv::VisionPositionEstimate& m : messages) {
    EXPECT_NEAR(at(m.x), 3, kFiveDeviations_m);
    EXPECT_NEAR(at(m.y), 2, kFiveDeviations_m);
    EXPECT_NEAR(at(m.yaw), base::radians(90), kFiveDeviations_rad);
    EXPECT_NEAR(at(m.covariance[0]), 1e-6, 1e-9);
  }
  EXPECT_EQ(messages.front().usec, 50'000U);
}

}  // namespace
}  // namespace cas::test
