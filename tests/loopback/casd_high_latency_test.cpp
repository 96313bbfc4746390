// SPDX-License-Identifier: BSD-3-Clause
// A vehicle on a satellite link, as the real casd tells of it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/rpc/client.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/udp_autopilot.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using namespace mavlink::common;
using nlohmann::json;

class CasdHighLatency : public testing::Test {
 protected:
  CasdHighLatency() {
    const std::string topology =
        folder.write("topology.yaml",
                     "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\n"
                     "links:\n  - {name: net, type: udp_server, local: \"127.0.0.1:0\"}\n");
    casd.emplace(std::vector<std::string>{kCasdProgram, topology});
    vehicle.socket.set_remote(casd->port("net"));
  }
  void tell(MavAutopilot kind, std::uint16_t custom_mode, std::int8_t custom0 = -128) {
    HighLatency2 message{.type = MavType::kQuadrotor,
                         .autopilot = kind,
                         .custom_mode = custom_mode,
                         .latitude = 473'977'420,
                         .longitude = 85'455'940,
                         .altitude = 510,
                         .heading = 45,
                         .battery = 77,
                         .failure_flags = HlFailureFlag::k3dMag,
                         .custom0 = custom0};
    vehicle.socket.send(vehicle.encoder(message));
  }
  json state() { return casd->call("vehicle.state", json{{"vehicle", 1}}); }
  bool is_known() { return casd->call("casd.status").at("vehicles").size() == 1; }

  TemporaryFolder folder;
  std::optional<RunningCasd> casd;
  UdpAutopilot vehicle{MavAutopilot::kPx4};
};

TEST_F(CasdHighLatency, APx4IsKnownByOneMessageAndIsNotSilent) {
  constexpr std::uint16_t kHold = 0x0304;  // PX4's sub mode LOITER, main mode AUTO
  tell(MavAutopilot::kPx4, kHold);
  ASSERT_TRUE(wait_until([&] { return is_known(); })) << casd->output();
  const json told = state();
  EXPECT_EQ(told.at("autopilot"), "PX4");
  EXPECT_EQ(told.at("mode"), "HOLD");
  EXPECT_FALSE(told.at("armed"));
  EXPECT_FALSE(told.at("hil"));
  EXPECT_EQ(told.at("silent_after_s"), 200);
  EXPECT_NEAR(told.at("global").at("lat_deg"), 47.397742, 1e-9);
  EXPECT_NEAR(told.at("global").at("alt_m"), 510, 1e-9);
  EXPECT_FALSE(told.at("global").contains("relative_alt_m"));
  EXPECT_EQ(told.at("complaints"), json::array({"magnetometer failure"}));
  const json telemetry = casd->call("vehicle.telemetry", json{{"vehicle", 1}});
  EXPECT_EQ(telemetry.at("battery").at("remaining_percent"), 77);
  EXPECT_EQ(telemetry.at("global").at("heading_deg"), 90);
  // Longer than a HEARTBEAT may be away.
  ASSERT_TRUE(wait_until([&] { return state().at("heartbeat_age_s") > 3.2; }));
  ChildProcess doctor(
      {binary_dir() + "/bin/casctl", "--address", casd->address(), "doctor", "--seconds", "0.1"});
  doctor.wait_exit();
  EXPECT_EQ(doctor.output().find("silent"), std::string::npos) << doctor.output();
  vehicle.pump();
  EXPECT_TRUE(vehicle.commands.empty()) << "each packet costs there";
}

TEST_F(CasdHighLatency, CannotBeArmedByIt) {
  constexpr std::int8_t kHilAndArmed = static_cast<std::int8_t>(128 | 32 | 1);
  tell(MavAutopilot::kArdupilotmega, 5, kHilAndArmed);
  ASSERT_TRUE(wait_until([&] { return is_known(); }));
  EXPECT_TRUE(state().at("armed")) << "ArduPilot has its base mode in custom0";
  EXPECT_FALSE(state().at("hil"));
  EXPECT_EQ(state().at("mode"), "LOITER");
  const std::string refused = casd->refusal("vehicle.arm", json{{"vehicle", 1}});
  EXPECT_NE(refused.find("HIL"), std::string::npos) << refused;
}

TEST_F(CasdHighLatency, AHeartbeatCountsMore) {
  vehicle.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
  ASSERT_TRUE(speaks_until(vehicle, [&] { return is_known(); }));
  vehicle.beat();
  tell(MavAutopilot::kPx4, 0x0304);
  ASSERT_TRUE(speaks_until(vehicle, [&] { return vehicle.requests >= 2; }));
  EXPECT_TRUE(state().at("hil"));
  EXPECT_EQ(state().at("silent_after_s"), 3);
}

}  // namespace
}  // namespace cas::test
