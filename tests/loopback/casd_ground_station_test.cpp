// SPDX-License-Identifier: BSD-3-Clause
// The shipped topologies, in the real casd: messages that a ground station may and may not send.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "casd/routing/ground_station_traffic.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "tests/base/config/scoped_environment.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

using namespace mavlink::common;  // NOLINT
using nlohmann::json;

struct TopologyCase {
  const char* name;        ///< of the file
  const char* controller;  ///< link with the controller of system 1
  const char* simulator;   ///< empty: the simulator does not pass through casd
  bool on_a_line;          ///< the controller is on a serial line
};

constexpr mav::Source kStation{255, 190};

Heartbeat heartbeat(MavType type, MavAutopilot autopilot, MavModeFlag mode = {}) {
  Heartbeat message{.type = type, .autopilot = autopilot, .base_mode = mode, .mavlink_version = 3};
  return message;
}

/// A packet of any public message for 1/1, its other fields zero.
std::vector<std::uint8_t> packet_of(std::uint32_t id, mav::Source from, std::uint8_t sequence) {
  const mav::MessageInfo& message = *mav::public_table().find(id);
  std::vector<std::uint8_t> bytes(mav::kHeaderBytesV2 + message.max_length + mav::kChecksumBytes);
  bytes[0] = mav::kStartV2;
  bytes[1] = message.max_length;
  bytes[4] = sequence;
  bytes[5] = from.system;
  bytes[6] = from.component;
  for (std::size_t i = 0; i < 3; ++i) bytes[7 + i] = static_cast<std::uint8_t>(id >> 8U * i);
  for (const int offset : {message.target_system_offset, message.target_component_offset}) {
    if (offset >= 0) bytes[mav::kHeaderBytesV2 + static_cast<std::size_t>(offset)] = 1;
  }
  mav::detail::append_checksum(bytes.data(), bytes.size() - mav::kChecksumBytes, message.crc_extra);
  return bytes;
}

class ShippedTopology : public testing::TestWithParam<TopologyCase> {
 protected:
  ShippedTopology() : lines_{{PtyPair(folder_ / "fcu0"), PtyPair(folder_ / "fcu1")}} {
    casd_.emplace(std::vector<std::string>{kCasdProgram, topology().string()});
    station_.set_remote(port_of(link("gcs").at("endpoint")));
    if (has_simulator()) {
      simulator_.set_remote(port_of(link(GetParam().simulator).at("endpoint")));
    }
    if (!GetParam().on_a_line) {
      controller_.set_remote(port_of(link(GetParam().controller).at("endpoint")));
    }
  }

  /// The shipped file with ports and devices of this test.
  std::filesystem::path topology() {
    std::string text =
        TemporaryFolder::read(source_dir() + "/config/topologies/" + GetParam().name + ".yaml");
    const auto replace = [&text](const std::string& pattern, const std::string& by) {
      text = std::regex_replace(text, std::regex(pattern), by);
    };
    replace("(\\n +)port: 5790", "$1loopback_without_token: true$1port: 0");
    replace("port: 5790", "port: 0, loopback_without_token: true");
    replace("local: 127\\.0\\.0\\.1:\\d+", "local: 127.0.0.1:0");
    replace("remote: 127\\.0\\.0\\.1:14560", "remote: " + simulator_.endpoint());
    replace("remote: 127\\.0\\.0\\.1:14570", "remote: " + other_simulator_.endpoint());
    replace("remote: 127\\.0\\.0\\.1:14550", "remote: " + station_.endpoint());
    replace("remote: 127\\.0\\.0\\.1:18570", "remote: " + controller_.endpoint());
    replace("device: /dev/\\S+", "device: \"$${CAS_RUNTIME_DIR}/fcu0\"");
    return folder_.write("casd.yaml", text);
  }

  bool has_simulator() const { return *GetParam().simulator != '\0'; }
  json link(const std::string& name) { return casd_->link(name); }
  std::uint64_t refused() { return link("gcs").at("rx").at("not_accepted"); }
  json vehicles() { return casd_->call("casd.status").at("vehicles"); }

  void from_controller(std::span<const std::uint8_t> bytes) {
    GetParam().on_a_line ? lines_[0].write(bytes) : controller_.send(bytes);
  }
  void collect() {
    lines_[0].read(at_controller_);
    controller_.read(at_controller_);
    simulator_.read(at_simulator_);
    station_.read(at_station_);
  }
  template <class Condition>
  bool collect_until(Condition&& condition) {
    return wait_until([&] {
      collect();
      return condition();
    });
  }
  /// Every node sends a HEARTBEAT, so that routes and the vehicle are known.
  void meet() {
    mav::Encoder vehicle({1, 1});
    mav::Encoder simulator({1, 200});
    mav::Encoder station(kStation);
    const auto in_hil = MavModeFlag::kHilEnabled;
    ASSERT_TRUE(collect_until([&] {
      station_.send(station(heartbeat(MavType::kGcs, MavAutopilot::kInvalid)));
      if (has_simulator()) {
        simulator_.send(simulator(heartbeat(MavType::kGeneric, MavAutopilot::kInvalid)));
      }
      from_controller(vehicle(heartbeat(MavType::kQuadrotor, MavAutopilot::kPx4, in_hil)));
      return at_station_.count(Heartbeat::kId) > 0 && vehicles().size() == 1 &&
             came(Heartbeat::kId, kStation);
    }));
  }
  bool came(std::uint32_t id, mav::Source from) {
    for (const PacketStream::Packet& packet : at_controller_.packets()) {
      if (packet.message_id == id && packet.source == from) return true;
    }
    return false;
  }

  TemporaryFolder folder_;
  base::ScopedEnvironment runtime_{"CAS_RUNTIME_DIR", folder_.path().c_str()};
  std::array<PtyPair, 2> lines_;
  UdpPeer simulator_;
  UdpPeer other_simulator_;
  UdpPeer controller_;
  UdpPeer station_;
  std::optional<RunningCasd> casd_;
  PacketStream at_controller_;
  PacketStream at_simulator_;
  PacketStream at_station_;
};

TEST_P(ShippedTopology, LetsAStationSayAllThatStationsSay) {
  ASSERT_NO_FATAL_FAILURE(meet());
  constexpr auto kOnce = std::chrono::milliseconds(500);  // one may grow old on a busy machine
  std::uint8_t sequence = 100;
  for (const std::uint32_t id : casd::ground_station_messages()) {
    if (id == Heartbeat::kId) continue;  // has been heard
    EXPECT_TRUE(wait_until([&] {
      station_.send(packet_of(id, kStation, sequence++));
      return wait_until(
          [&] {
            collect();
            return came(id, kStation);
          },
          kOnce);
    })) << mav::public_table().find(id)->name;
  }
  EXPECT_EQ(refused(), 0U);
}

TEST_P(ShippedTopology, LetsNoStationFlyTheVehicleOrSpeakInItsName) {
  ASSERT_NO_FATAL_FAILURE(meet());
  const json before = vehicles();
  mav::Encoder station(kStation);
  mav::Encoder as_vehicle({1, 1});
  mav::Encoder as_simulator({1, 200});
  mav::Encoder as_another({77, 1});
  std::uint64_t sent = 0;
  const auto say = [&](std::span<const std::uint8_t> bytes) {
    station_.send(bytes);
    ++sent;
  };
  const auto not_in_hil = heartbeat(MavType::kQuadrotor, MavAutopilot::kPx4);
  say(station(HilSensor{}));
  say(station(HilGps{}));
  say(station(HilStateQuaternion{}));
  say(station(HilControls{}));
  say(station(VisionPositionEstimate{}));
  say(station(GpsInput{}));
  say(as_simulator(HilSensor{}));
  say(as_vehicle(HilControls{}));
  say(as_vehicle(HilActuatorControls{}));
  say(as_vehicle(not_in_hil));
  say(as_vehicle(CommandLong{.target_system = 1, .target_component = 1}));
  say(as_vehicle(Statustext{}));
  say(as_another(not_in_hil));
  ASSERT_TRUE(collect_until([&] { return refused() == sent; })) << refused() << " of " << sent;
  // A later packet has arrived, so these would have, too.
  station_.send(station(ParamRequestList{.target_system = 1, .target_component = 1}));
  ASSERT_TRUE(collect_until([&] { return came(ParamRequestList::kId, kStation); }));

  for (const PacketStream::Packet& packet : at_controller_.packets()) {
    EXPECT_NE(packet.source, (mav::Source{1, 1})) << packet.message_id;
    EXPECT_NE(packet.source.system, 77) << packet.message_id;
    const std::string name(mav::public_table().find(packet.message_id)->name);
    EXPECT_FALSE(name.starts_with("HIL_")) << name;
    EXPECT_NE(packet.message_id, GpsInput::kId);
    EXPECT_NE(packet.message_id, VisionPositionEstimate::kId);
  }
  for (const PacketStream::Packet& packet : at_simulator_.packets()) {
    EXPECT_NE(packet.source, kStation) << packet.message_id;
    EXPECT_NE(packet.source.system, 77) << packet.message_id;
    if (packet.source != mav::Source{1, 1}) continue;  // casd's own station
    const auto beat = mav::decode<Heartbeat>(packet.view());
    ASSERT_TRUE(beat) << packet.message_id << " in the vehicle's name";
    EXPECT_TRUE(has(beat->base_mode, MavModeFlag::kHilEnabled)) << "not the vehicle's own";
  }
  const json after = vehicles();
  ASSERT_EQ(after.size(), 1U) << after;
  EXPECT_EQ(after[0].at("link"), before[0].at("link"));
  EXPECT_EQ(after[0].at("hil"), true) << after;
  EXPECT_FALSE(after[0].contains("rival")) << after;
}

INSTANTIATE_TEST_SUITE_P(Each, ShippedTopology,
                         testing::Values(TopologyCase{"bench_pty", "fcu", "sim", true},
                                         TopologyCase{"bench_single_thread", "fcu", "sim", true},
                                         TopologyCase{"two_vehicles", "fcu0", "sim0", true},
                                         TopologyCase{"pixhawk_usb", "fcu", "sim", true},
                                         TopologyCase{"pixhawk_telem", "fcu", "sim", true},
                                         TopologyCase{"px4_sitl", "px4", "", false},
                                         TopologyCase{"px4_companion", "px4", "", false},
                                         TopologyCase{"ardupilot_hil", "fcu", "sim", true},
                                         TopologyCase{"ardupilot_sitl", "ardupilot", "", false},
                                         TopologyCase{"ardupilot_companion", "ardupilot", "",
                                                      false}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(ShippedTopologies, AllPlayAboveAreAllThatThereAre) {
  std::set<std::string> files;
  const std::string folder = source_dir() + "/config/topologies";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files.insert(entry.path().stem());
  }
  EXPECT_EQ(files,
            (std::set<std::string>{"bench_pty", "bench_single_thread", "two_vehicles",
                                   "pixhawk_usb", "pixhawk_telem", "px4_sitl", "px4_companion",
                                   "ardupilot_sitl", "ardupilot_companion", "ardupilot_hil"}));
}

}  // namespace
}  // namespace cas::test
