// SPDX-License-Identifier: BSD-3-Clause
// Two autopilots with one system id, companions and floods before the real casd.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <nlohmann/json.hpp>

#include "base/rpc/client.hpp"
#include "base/rpc/server.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/scripted_vehicle.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

using base::rpc::CallError;
using casd::test::FakeVehicle;
using mavlink::common::Heartbeat;
using mavlink::common::MavAutopilot;
using mavlink::common::MavCmd;
using mavlink::common::MavModeFlag;
using mavlink::common::MavType;
using nlohmann::json;
using testing::HasSubstr;

constexpr int kInterlock = -32004;

void without_hil(FakeVehicle& vehicle) { vehicle.base_mode = MavModeFlag::kCustomModeEnabled; }
void in_hil(FakeVehicle&) {}

/// A UDP socket at the controller's end, for a ScriptedVehicle.
class UdpLine {
 public:
  explicit UdpLine(std::uint16_t casd_port) { peer_.set_remote(casd_port); }
  void write(std::span<const std::uint8_t> bytes) { peer_.send(bytes); }
  void read(PacketStream& into) { peer_.read(into); }

 private:
  UdpPeer peer_;
};
using UdpVehicle = BasicScriptedVehicle<UdpLine>;

/// Two redundant ways to one vehicle.
class UdpPair {
 public:
  UdpPair(std::uint16_t first, std::uint16_t second) : first_(first), second_(second) {}
  void write(std::span<const std::uint8_t> bytes) {
    if (!cut_.load()) first_.write(bytes);
    second_.write(bytes);
  }
  void read(PacketStream& into) {
    first_.read(into);
    second_.read(into);
  }
  /// Nothing comes over the first way any more.
  void cut() { cut_.store(true); }

 private:
  UdpLine first_;
  UdpLine second_;
  std::atomic<bool> cut_{false};
};

int arm_commands(const FakeVehicle& vehicle) {
  return static_cast<int>(
      std::count_if(vehicle.commands.begin(), vehicle.commands.end(), [](const auto& command) {
        return command.command == MavCmd::kComponentArmDisarm && command.param1 != 0;
      }));
}

/// Arm commands that a stopped vehicle has not read.
int arm_commands_left(UdpLine& line) {
  PacketStream left;
  line.read(left);
  FakeVehicle vehicle;
  for (const PacketStream::Packet& packet : left.packets()) vehicle.handle(packet.view(), {});
  return arm_commands(vehicle);
}

/// The real casd with a line, a server, and a socket whose newest sender is its peer.
class CasdInterlock : public testing::Test {
 protected:
  CasdInterlock() : line_(folder_ / "fcu0") {
    const auto topology =
        folder_.write("casd.yaml",
                      "schema: 1\n"
                      "command_port: {port: 0, loopback_without_token: true}\n"
                      "links:\n"
                      "  - {name: fcu, type: serial, baud: 921600, device: '" +
                          (folder_ / "fcu0").string() +
                          "'}\n"
                          "  - {name: net, type: udp_server, local: '127.0.0.1:0'}\n"
                          "  - {name: newest, type: udp, local: '127.0.0.1:0'}\n"
                          "  - {name: one, type: udp_server, local: '127.0.0.1:0', group: pair}\n"
                          "  - {name: two, type: udp_server, local: '127.0.0.1:0', group: pair}\n");
    casd_.emplace(std::vector<std::string>{kCasdProgram, topology.string()});
    for (const json& link : casd_->call("link.list")) {
      if (link.at("type") != "serial") ports_[link.at("name")] = port_of(link.at("endpoint"));
    }
  }

  json vehicles() { return casd_->call("casd.status").at("vehicles"); }
  /// Waits until the one vehicle that casd knows is as the condition wants it.
  template <class Condition>
  bool wait_vehicle(Condition&& condition) {
    return wait_until([&] {
      const json all = vehicles();
      return all.size() == 1 && condition(all.front());
    });
  }
  bool wait_known(const std::string& link) {
    return wait_vehicle([&](const json& vehicle) { return vehicle.at("link") == link; });
  }
  bool wait_alone(const std::string& link) {
    return wait_vehicle([&](const json& vehicle) {
      return vehicle.at("link") == link && !vehicle.contains("rival");
    });
  }
  /// @return the sentence of the interlock, or another error's code
  std::string arm_refusal(json params = json::object()) {
    try {
      casd_->call("vehicle.arm", params);
    } catch (const CallError& error) {
      return error.code() == kInterlock ? error.what() : "code " + std::to_string(error.code());
    }
    return "armed";
  }
  /// Waits until the vehicle has a rival: then nothing arms it.
  void expect_contested() {
    ASSERT_TRUE(wait_vehicle([](const json& vehicle) { return vehicle.contains("rival"); }));
    EXPECT_THAT(arm_refusal(), HasSubstr("vehicle 1 is not alone"));
    EXPECT_THAT(arm_refusal({{"not_hil", true}, {"force", true}}),
                HasSubstr("vehicle 1 is not alone"));
  }

  TemporaryFolder folder_;
  PtyPair line_;
  std::optional<RunningCasd> casd_;
  std::map<std::string, std::uint16_t> ports_;
};

TEST_F(CasdInterlock, ARealVehicleIsNotArmedByTheHilFlagOfOneThatSpeaksLater) {
  ScriptedVehicle real(line_, without_hil);
  ASSERT_TRUE(wait_known("fcu"));
  UdpLine net(ports_.at("net"));
  UdpVehicle twin(net, in_hil);
  expect_contested();
  EXPECT_EQ(arm_commands(real.stop()), 0);
  EXPECT_EQ(arm_commands(twin.stop()), 0);
  EXPECT_TRUE(casd_->prints("vehicle 1 has a rival")) << casd_->output();
}

TEST_F(CasdInterlock, ARealVehicleIsNotArmedByTheHilFlagOfOneThatSpokeFirst) {
  UdpLine net(ports_.at("net"));
  UdpVehicle twin(net, in_hil);
  ASSERT_TRUE(wait_known("net"));
  ScriptedVehicle real(line_, without_hil);
  expect_contested();
  // The twin falls silent: the real vehicle's own HEARTBEAT decides, and it says no.
  EXPECT_EQ(arm_commands(twin.stop()), 0);
  ASSERT_TRUE(wait_alone("fcu"));
  EXPECT_THAT(arm_refusal(), HasSubstr("does not say that it is in HIL mode"));
  EXPECT_EQ(arm_commands(real.stop()), 0);
}

TEST_F(CasdInterlock, PeersOfOneServerDoNotShareAVehicle) {
  UdpLine first(ports_.at("net"));
  UdpVehicle real(first, without_hil);
  ASSERT_TRUE(wait_known("net"));
  UdpLine second(ports_.at("net"));
  UdpVehicle twin(second, in_hil);
  expect_contested();
  EXPECT_EQ(arm_commands(real.stop()), 0);
  // Once the real one is silent, commands go to the twin's socket alone.
  ASSERT_TRUE(wait_vehicle(
      [](const json& vehicle) { return vehicle.at("hil") == true && !vehicle.contains("rival"); }));
  EXPECT_EQ(arm_refusal(), "armed");
  EXPECT_GE(arm_commands(twin.stop()), 1);  // again, when the answer is late
  EXPECT_EQ(arm_commands_left(first), 0);
}

TEST_F(CasdInterlock, SendersThatTakeTurnsAsTheNewestPeerDoNotShareAVehicle) {
  UdpLine first(ports_.at("newest"));
  UdpVehicle real(first, without_hil);
  ASSERT_TRUE(wait_known("newest"));
  UdpLine second(ports_.at("newest"));
  UdpVehicle twin(second, in_hil);
  expect_contested();
  EXPECT_EQ(arm_commands(real.stop()), 0);
  EXPECT_EQ(arm_commands(twin.stop()), 0);
}

TEST_F(CasdInterlock, ArmsAgainWhenTheTwinIsSilent) {
  ScriptedVehicle vehicle(line_, in_hil);
  ASSERT_TRUE(wait_known("fcu"));
  UdpLine net(ports_.at("net"));
  UdpVehicle twin(net, in_hil);
  expect_contested();
  EXPECT_EQ(arm_commands(twin.stop()), 0);
  ASSERT_TRUE(wait_alone("fcu"));
  EXPECT_EQ(arm_refusal(), "armed");
  EXPECT_GE(arm_commands(vehicle.stop()), 1);
  EXPECT_EQ(arm_commands_left(net), 0);
}

TEST_F(CasdInterlock, AVehicleOnTwoLinksOfAGroupIsOneVehicle) {
  UdpPair pair(ports_.at("one"), ports_.at("two"));
  BasicScriptedVehicle<UdpPair> vehicle(pair, in_hil);
  ASSERT_TRUE(wait_until([this] {
    const json links = casd_->call("link.list");
    return std::any_of(links.begin(), links.end(), [](const json& link) {
      return link.at("rx").at("verdicts").at("duplicate") >= 3;
    });
  }));
  ASSERT_TRUE(wait_vehicle([](const json& one) { return !one.contains("rival"); }));
  EXPECT_EQ(arm_refusal(), "armed");
  pair.cut();
  ASSERT_TRUE(wait_alone("two"));
  EXPECT_EQ(arm_refusal(), "armed");
}

struct CompanionCase {
  const char* name;
  MavAutopilot autopilot;
  bool makes_a_vehicle;
};

class Companion : public CasdInterlock, public testing::WithParamInterface<CompanionCase> {};

TEST_P(Companion, ThatSpeaksFirstDoesNotKeepTheAutopilotOut) {
  Heartbeat heartbeat{.type = MavType::kGimbal,
                      .autopilot = GetParam().autopilot,
                      .base_mode = MavModeFlag::kHilEnabled};
  mav::Encoder companion({1, 2});
  ASSERT_TRUE(wait_until([&] {
    line_.write(companion(heartbeat));
    for (const json& link : casd_->call("link.list")) {
      if (link.at("name") == "fcu" && link.at("rx").at("packets") >= 3) return true;
    }
    return false;
  }));
  if (GetParam().makes_a_vehicle) {
    ASSERT_TRUE(wait_known("fcu"));
    EXPECT_EQ(vehicles().at(0).at("component"), 2);
  } else {
    EXPECT_TRUE(vehicles().empty());
  }
  ScriptedVehicle vehicle(line_, in_hil);
  ASSERT_TRUE(wait_vehicle([](const json& one) { return one.at("component") == 1; }));
  EXPECT_EQ(casd_->call("vehicle.arm").at("result"), "ACCEPTED");
  EXPECT_EQ(casd_->call("vehicle.disarm").at("result"), "ACCEPTED");
}

INSTANTIATE_TEST_SUITE_P(
    Heartbeat, Companion,
    testing::Values(CompanionCase{"WithoutAutopilot", MavAutopilot::kInvalid, false},
                    CompanionCase{"Generic", MavAutopilot::kGeneric, false},
                    CompanionCase{"ThatCallsItselfPx4", MavAutopilot::kPx4, true}),
    [](const auto& test) { return test.param.name; });

TEST_F(CasdInterlock, InventedSystemsOnOneLinkKeepNoVehicleOfAnotherOut) {
  Heartbeat heartbeat{.type = MavType::kQuadrotor, .autopilot = MavAutopilot::kPx4};
  UdpLine net(ports_.at("net"));
  const auto flood = [&] {
    for (int system = 2; system <= 255; ++system) {  // four more than a link may have
      net.write(mav::Encoder({static_cast<std::uint8_t>(system), 1})(heartbeat));
    }
  };
  ASSERT_TRUE(wait_until([&] {
    flood();
    return vehicles().size() == 250;
  }));
  ScriptedVehicle vehicle(line_, in_hil);
  ASSERT_TRUE(wait_until([&] {
    flood();
    return vehicles().size() == 251;
  }));
  EXPECT_EQ(arm_refusal({{"vehicle", 1}}), "armed");
  EXPECT_GE(arm_commands(vehicle.stop()), 1);
}

}  // namespace
}  // namespace cas::test
