// SPDX-License-Identifier: BSD-3-Clause
// MAV_CMD_INJECT_FAILURE of a ground station through the real casd into the real hilsim.
#include <gmock/gmock.h>

#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/rpc/client.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/services/failure_order.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using namespace mavlink::common;
using Type = mav::services::FailureType;
using Unit = mav::services::FailureUnit;
using mav::services::FailureOrder;
using nlohmann::json;
using testing::HasSubstr;

/// hilsim -- casd -- a controller that this test plays, and two ground stations of which one may.
class FailureInjection : public testing::Test {
 protected:
  FailureInjection() {
    start_casd();
    start_hilsim();
  }

  void start_casd() {
    const auto topology = folder_.write("casd.yaml", R"(schema: 1
command_port: {port: 0, loopback_without_token: true}
links:
  - {name: sim, type: udp_server, local: '127.0.0.1:0', queue: {hil_max_age_ms: 60000}}
  - {name: fcu, type: udp_server, local: '127.0.0.1:0',
     queue: {hil_max_age_ms: 60000, gps_max_age_ms: 60000}}
  - {name: may, type: udp_server, local: '127.0.0.1:0', inject_failures: true,
     accept: {traffic: ground_station, block_systems: [1]}}
  - {name: may_not, type: udp_server, local: '127.0.0.1:0',
     accept: {traffic: ground_station, block_systems: [1]}}
routes:
  - {from: sim, to: fcu, allow: [HIL_SENSOR, HIL_GPS]}
  - {from: may, to: fcu}
  - {from: may_not, to: fcu}
  - {from: fcu, to: may, block: [HIL_CONTROLS]}
  - {from: fcu, to: may_not, block: [HIL_CONTROLS]}
)");
    casd_ =
        std::make_unique<RunningCasd>(std::vector<std::string>{kCasdProgram, topology.string()});
    for (const json& link : casd_->call("link.list")) {
      ports_[link.at("name")] = port_of(link.at("endpoint"));
    }
    controller_.set_remote(ports_.at("fcu"));
    may_.set_remote(ports_.at("may"));
    may_not_.set_remote(ports_.at("may_not"));
  }

  void start_hilsim() {
    const auto config = folder_.write("sim.yaml", R"(schema: 1
world: {gravity_m_s2: 9.80665, ground: true}
home: {lat_deg: 47.4, lon_deg: 8.5, alt_m: 488}
decimal_year: 2026.5
pace: realtime
vehicles:
  - name: iris
    vehicle: )" + source_dir() + R"(/config/vehicles/iris_paper.yaml
    pose: {z_m: 0.2}
    sensors:
      imu: {rate_hz: 100, gyro_stddev_deg_s: 0.1, accel_stddev_m_s2: 0.1}
      gps: {rate_hz: 20, position_stddev_m: 0.3, velocity_stddev_m_s: 0.1, eph_m: 0.4, epv_m: 0.3, satellites: 10}
    plugins:
      - {plugin: motor}
      - {plugin: imu}
      - {plugin: gps}
      - {plugin: fault, by_hand: true}
      - {plugin: mavlink_interface, transport: udp, local: '127.0.0.1:0', remote: '127.0.0.1:)" +
                                                      std::to_string(ports_.at("sim")) + R"('}
)");
    hilsim_ = std::make_unique<ChildProcess>(std::vector<std::string>{
        binary_dir() + "/bin/hilsim", config.string(), "--control", (folder_ / "control").string(),
        "--plugin-dir", binary_dir() + "/plugins"});
    if (!hilsim_->wait_ready()) throw std::runtime_error(hilsim_->output());
  }

  /// Sends all HEARTBEATs, and reads waiting packets.
  void turn() {
    if (base::steady_now() > beat_at_) {
      Heartbeat vehicle;
      vehicle.type = MavType::kQuadrotor;
      vehicle.autopilot = MavAutopilot::kPx4;
      vehicle.base_mode = in_hil_ ? MavModeFlag::kHilEnabled : MavModeFlag::kCustomModeEnabled;
      controller_.send(as_controller_(vehicle));
      Heartbeat station;
      station.type = MavType::kGcs;
      station.autopilot = MavAutopilot::kInvalid;
      may_.send(as_station_(station));
      may_not_.send(as_station_(station));
      beat_at_ = base::steady_now() + std::chrono::milliseconds(100);
    }
    controller_.read(at_controller_);
    may_.read(at_may_);
    may_not_.read(at_may_not_);
  }
  template <class Condition>
  bool wait(Condition&& condition) {
    return wait_until([&] {
      turn();
      return condition();
    });
  }
  std::size_t fixes() const { return at_controller_.count(HilGps::kId); }
  std::size_t sensors() const { return at_controller_.count(HilSensor::kId); }
  bool knows_vehicle() {
    return wait([&] {
      return casd_->call("casd.status").at("vehicles").size() == 1 && fixes() > 0 && sensors() > 0;
    });
  }
  /// Sends an order until it is answered; on a busy machine hilsim may be late for the first.
  /// @return the answer
  std::optional<CommandAck> inject(UdpPeer& station, PacketStream& heard,
                                   const FailureOrder& order) {
    heard.packets().clear();
    std::optional<CommandAck> answer;
    base::RunTime again{};
    wait([&] {
      if (base::steady_now() > again) {
        station.send(as_station_(mav::services::command_of(order, {1, 1})));
        again = base::steady_now() + std::chrono::seconds(2);
      }
      for (const PacketStream::Packet& packet : heard.packets()) {
        const auto ack = mav::decode<CommandAck>(packet.view());
        if (!ack || ack->command != MavCmd::kInjectFailure) continue;
        EXPECT_EQ(packet.source, (mav::Source{1, 1})) << "stations wait for the vehicle's answer";
        if (ack->result != MavResult::kFailed) answer = ack;
      }
      return answer.has_value();
    });
    return answer;
  }
  static bool heard_text(PacketStream& heard, const std::string& words) {
    for (const PacketStream::Packet& packet : heard.packets()) {
      const auto text = mav::decode<Statustext>(packet.view());
      if (text && mav::text(text->text) == words) return true;
    }
    return false;
  }
  /// Whether the autopilot was ever sent the command.
  bool autopilot_got_it() {
    for (const PacketStream::Packet& packet : at_controller_.packets()) {
      autopilot_got_it_ |= mav::services::failure_command(packet.view()).has_value();
    }
    return autopilot_got_it_;
  }
  /// Waits until so many sensor messages more have come. @return fixes among them
  std::size_t fixes_in(std::size_t messages) {
    autopilot_got_it();
    at_controller_.packets().clear();
    EXPECT_TRUE(wait([&] { return sensors() >= messages; })) << hilsim_->output();
    return fixes();
  }

  TemporaryFolder folder_;
  std::unique_ptr<RunningCasd> casd_;
  std::unique_ptr<ChildProcess> hilsim_;
  std::map<std::string, std::uint16_t> ports_;
  UdpPeer controller_, may_, may_not_;
  PacketStream at_controller_, at_may_, at_may_not_;
  mav::Encoder as_controller_{{1, 1}};
  mav::Encoder as_station_{{255, 190}};
  base::RunTime beat_at_{};
  bool in_hil_ = true;
  bool autopilot_got_it_ = false;
};

TEST_F(FailureInjection, StrikesInTheSimulatorAndEnds) {
  ASSERT_TRUE(knows_vehicle()) << casd_->output() << hilsim_->output();
  const auto off = inject(may_, at_may_, {Unit::kGps, Type::kOff});
  ASSERT_TRUE(off) << casd_->output() << hilsim_->output();
  EXPECT_EQ(off->result, MavResult::kAccepted) << hilsim_->output();
  EXPECT_EQ(off->target_system, 255);
  // Fixes in flight have arrived with the first of them.
  fixes_in(50);
  EXPECT_EQ(fixes_in(100), 0U) << "a second without a fix, at 20 Hz";
  EXPECT_THAT(
      casd_->output(),
      HasSubstr("audit: 255/190 on link may MAV_CMD_INJECT_FAILURE 'gps off' vehicle 1: accepted"));

  const auto ended = inject(may_, at_may_, {Unit::kGps, Type::kOk});
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->result, MavResult::kAccepted);
  EXPECT_TRUE(wait([&] { return fixes() > 3; })) << hilsim_->output();

  const auto servo = inject(may_, at_may_, {Unit::kServo, Type::kOff});
  ASSERT_TRUE(servo);
  EXPECT_EQ(servo->result, MavResult::kUnsupported);
  EXPECT_TRUE(heard_text(at_may_, "casd: the simulator has no such unit"));

  // The command port does the same.
  EXPECT_TRUE(wait([&] {
    try {
      casd_->call("vehicle.command", {{"command", 420}, {"params", {4, 1, 0}}});
      return true;
    } catch (const base::rpc::CallError&) {  // late, as above
      return false;
    }
  }));
  fixes_in(50);
  EXPECT_EQ(fixes_in(100), 0U);
  EXPECT_FALSE(autopilot_got_it());
}

TEST_F(FailureInjection, IsDeniedToALinkThatMayNot) {
  ASSERT_TRUE(knows_vehicle()) << casd_->output() << hilsim_->output();
  const auto denied = inject(may_not_, at_may_not_, {Unit::kGps, Type::kOff});
  ASSERT_TRUE(denied) << casd_->output();
  EXPECT_EQ(denied->result, MavResult::kDenied);
  EXPECT_TRUE(heard_text(at_may_not_, "casd: this link may not inject failures"));
  fixes_in(50);
  EXPECT_GT(fixes_in(100), 10U);
  EXPECT_FALSE(autopilot_got_it());
  EXPECT_THAT(casd_->output(),
              HasSubstr("this link may not inject failures: inject_failures: true"));
}

TEST_F(FailureInjection, IsDeniedForAVehicleThatMayBeReal) {
  in_hil_ = false;
  ASSERT_TRUE(knows_vehicle()) << casd_->output() << hilsim_->output();
  const auto denied = inject(may_, at_may_, {Unit::kGps, Type::kOff});
  ASSERT_TRUE(denied) << casd_->output();
  EXPECT_EQ(denied->result, MavResult::kDenied);
  EXPECT_TRUE(heard_text(at_may_, "casd: the vehicle is not known to be in HIL"));
  fixes_in(50);
  EXPECT_GT(fixes_in(100), 10U);
  EXPECT_FALSE(autopilot_got_it());
}

}  // namespace
}  // namespace cas::test
