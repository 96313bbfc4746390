// SPDX-License-Identifier: BSD-3-Clause
// Links that are added to a running casd and taken out.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using mavlink::common::Attitude;
using mavlink::common::Heartbeat;
using mavlink::common::HilSensor;
using mavlink::common::MavModeFlag;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class RunTimeLinks : public testing::Test {
 protected:
  void SetUp() override {
    write_topology("");
    casd_.emplace(std::vector<std::string>{kCasdProgram, file_});
    vehicle_.set_remote(port("fcu"));
  }
  /// A vehicle's link and further given ones; every link talks to every other one.
  void write_topology(const std::string& more) {
    file_ = folder_.write("links.yaml",
                          "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\n"
                          "commanding: {heartbeat_hz: 0}\nlinks:\n"
                          "  - {name: fcu, type: udp, remote: \"" +
                              vehicle_.endpoint() + "\"}\n" + more);
  }
  json call(const std::string& method, const json& params = json::object()) {
    return casd_->call(method, params);
  }
  std::optional<json> link(const std::string& name) { return casd_->find_link(name); }
  /// Where a link is bound, once it is up.
  std::uint16_t port(const std::string& name) {
    EXPECT_TRUE(wait_until([&] {
      const auto it = link(name);
      return it && (*it)["state"] == "up";
    })) << name;
    const auto it = link(name);
    return it ? port_of((*it)["endpoint"]) : std::uint16_t{0};
  }
  json entry_to(const UdpPeer& station) {
    return {{"name", "gcs"}, {"type", "udp"}, {"remote", station.endpoint()}};
  }
  /// A HEARTBEAT of an autopilot in HIL.
  static Heartbeat heartbeat(bool armed) {
    Heartbeat heartbeat;
    heartbeat.type = mavlink::common::MavType::kQuadrotor;
    heartbeat.autopilot = mavlink::common::MavAutopilot::kPx4;
    heartbeat.base_mode = MavModeFlag::kHilEnabled;
    if (armed) heartbeat.base_mode = heartbeat.base_mode | MavModeFlag::kSafetyArmed;
    return heartbeat;
  }
  void meet_vehicle(bool armed) {
    vehicle_.send(from_vehicle_(heartbeat(armed)));
    ASSERT_TRUE(wait_until([&] { return call("casd.status")["vehicles"].size() == 1; }));
  }
  std::string casctl(const std::vector<std::string>& words, int expected = 0) {
    const Ended program = casd_->casctl(words);
    EXPECT_EQ(program.code, expected) << program.output;
    return program.output;
  }

  TemporaryFolder folder_;
  UdpPeer vehicle_;
  mav::Encoder from_vehicle_{{1, 1}};
  std::string file_;
  std::optional<RunningCasd> casd_;
};

TEST_F(RunTimeLinks, AnAddedLinkCarriesPacketsBothWaysUntilItIsRemoved) {
  UdpPeer station;
  EXPECT_EQ(call("link.add", {{"entry", entry_to(station)}})["link"], "gcs");
  station.set_remote(port("gcs"));
  EXPECT_EQ((*link("gcs"))["added"], true);
  EXPECT_EQ((*link("gcs"))["remote"], station.endpoint());
  EXPECT_FALSE(link("fcu")->contains("added"));

  PacketStream at_station;
  ASSERT_TRUE(wait_until([&] {
    vehicle_.send(from_vehicle_(Attitude{}));
    station.read(at_station);
    return at_station.count(Attitude::kId) > 0;
  }));
  PacketStream at_vehicle;
  mav::Encoder from_station{{255, 190}};
  ASSERT_TRUE(wait_until([&] {
    station.send(from_station(mavlink::common::SystemTime{}));
    vehicle_.read(at_vehicle);
    return at_vehicle.count(mavlink::common::SystemTime::kId) > 0;
  }));

  call("link.remove", {{"link", "gcs"}});
  EXPECT_FALSE(link("gcs"));
  EXPECT_EQ(call("link.routes").size(), 0U);
  const json journal = call("casd.journal")["calls"];
  ASSERT_EQ(journal.size(), 2U);
  EXPECT_EQ(journal[0]["method"], "link.add");
  EXPECT_EQ(journal[0]["params"]["entry"]["name"], "gcs");
  EXPECT_EQ(journal[1]["method"], "link.remove");
  EXPECT_TRUE(casd_->prints("link.remove {"));
}

TEST_F(RunTimeLinks, WithoutAcceptItTakesInWhatGroundStationsSayAndNoKnownVehicle) {
  meet_vehicle(false);
  UdpPeer stranger;
  call("link.add", {{"entry", entry_to(stranger)}});
  stranger.set_remote(port("gcs"));
  mav::Encoder as_vehicle{{1, 1}};
  mav::Encoder as_other{{7, 1}};
  stranger.send(as_vehicle(heartbeat(true)));  // in the name of the vehicle
  stranger.send(as_other(heartbeat(false)));   // another autopilot
  stranger.send(as_other(HilSensor{}));        // a simulator
  ASSERT_TRUE(wait_until([&] { return (*link("gcs"))["rx"]["not_accepted"] == 3; }))
      << link("gcs")->dump();
  EXPECT_EQ(call("casd.status")["vehicles"].size(), 1U);
}

TEST_F(RunTimeLinks, AcceptEverythingIsToldAndEvenThenNoHilMessagePasses) {
  UdpPeer other;
  json entry = entry_to(other);
  entry["accept"] = "everything";
  call("link.add", {{"entry", entry}});
  other.set_remote(port("gcs"));
  mav::Encoder as_other{{7, 1}};
  PacketStream at_vehicle;
  ASSERT_TRUE(wait_until([&] {
    other.send(as_other(HilSensor{}));
    other.send(as_other(heartbeat(false)));
    vehicle_.read(at_vehicle);
    return at_vehicle.count(Heartbeat::kId) > 0;
  }));
  EXPECT_EQ(at_vehicle.count(HilSensor::kId), 0U);
}

TEST_F(RunTimeLinks, TakesItsRoutesAsATopologyHasThem) {
  UdpPeer station;
  const json routes = json::array({{{"from", "any"}, {"to", "gcs"}, {"allow", {"ATTITUDE"}}}});
  call("link.add", {{"entry", entry_to(station)}, {"routes", routes}});
  const json in_force = call("link.routes");
  ASSERT_EQ(in_force.size(), 1U);
  EXPECT_EQ(in_force[0]["from"], "fcu");
  EXPECT_EQ(in_force[0]["allow"], json::array({"ATTITUDE"}));
}

TEST_F(RunTimeLinks, SaysWhatIsWrongByItsKeyAndChangesNothing) {
  const auto wrong = [&](const json& more, const json& routes = json::array()) {
    json entry{{"name", "gcs"}, {"type", "udp_server"}, {"local", "127.0.0.1:0"}};
    entry.update(more);
    return casd_->refusal("link.add", {{"entry", entry}, {"routes", routes}});
  };
  EXPECT_EQ(wrong({{"max_peers", 0}}), "link.add:1: entry.max_peers: 0 must lie in [1, 64]");
  EXPECT_THAT(wrong({{"local", "nowhere"}}), HasSubstr("entry.local: 'nowhere' is not HOST:PORT"));
  EXPECT_THAT(wrong({{"name", "fcu"}}), HasSubstr("entry.name: 'fcu' is the name of another link"));
  EXPECT_THAT(wrong({{"bauds", 5}}), HasSubstr("bauds"));
  EXPECT_THAT(wrong(json::object(), json::array({{{"from", "gcs"}, {"to", "nowhere"}}})),
              HasSubstr("routes[0].to: there is no link 'nowhere'"));
  EXPECT_THAT(wrong(json::object(), json::array({{{"from", "fcu"}, {"to", "fcu"}}})),
              HasSubstr("routes[0]"));
  EXPECT_EQ(casd_->refusal("link.add", {{"entry", "udp"}}),
            "\"entry\" must be an object: a link, as a topology has it");
  EXPECT_THAT(casd_->refusal("link.remove", {{"link", "gcs"}}),
              HasSubstr("there is no link 'gcs'"));
  EXPECT_THAT(casd_->refusal("link.remove", {{"link", "fcu"}}), HasSubstr("is the only link"));
  EXPECT_EQ(call("link.list").size(), 1U);
}

TEST_F(RunTimeLinks, ALinkThatCannotBeMadeLeavesEverythingAsItWas) {
  rlimit before{};
  ASSERT_EQ(::prlimit(casd_->pid(), RLIMIT_NOFILE, nullptr, &before), 0);
  const rlimit full{.rlim_cur = 3, .rlim_max = before.rlim_max};  // beside those that are open
  ASSERT_EQ(::prlimit(casd_->pid(), RLIMIT_NOFILE, &full, nullptr), 0);
  UdpPeer station;
  json entry = entry_to(station);
  entry["scheduling"] = {{"cpus", {0}}};  // a thread of its own takes descriptors
  EXPECT_NE(casd_->refusal("link.add", {{"entry", entry}}), "");
  ASSERT_EQ(::prlimit(casd_->pid(), RLIMIT_NOFILE, &before, nullptr), 0);
  EXPECT_EQ(call("link.list").size(), 1U);
  EXPECT_EQ(call("link.add", {{"entry", entry}})["link"], "gcs");  // now there is room
}

TEST_F(RunTimeLinks, AReloadEndsThoseThatTheFileDoesNotHave) {
  UdpPeer station;
  UdpPeer other;
  call("link.add", {{"entry", entry_to(station)}});
  call("link.add", {{"entry", {{"endpoint", "udp:" + other.endpoint()}}}});
  const std::uint16_t gcs = port("gcs");
  ASSERT_NE(port("udp"), 0);

  // The file has one of them now: it goes on as it is.
  write_topology("  - {name: gcs, type: udp, remote: \"" + station.endpoint() +
                 "\", accept: {traffic: ground_station, block_systems: [254]}}\n");
  call("casd.reload");
  EXPECT_FALSE(link("udp"));
  EXPECT_EQ(port("gcs"), gcs);
  EXPECT_FALSE(link("gcs")->contains("added"));
  EXPECT_TRUE(casd_->prints("link udp: not in the topology, ended")) << casd_->output();
}

TEST_F(RunTimeLinks, IsAnsweredOnceTheLinkHasTriedToOpen) {
  for (int i = 0; i < 30; ++i) {
    call("link.add",
         {{"entry", {{"name", "lan"}, {"type", "udp_server"}, {"local", "127.0.0.1:0"}}}});
    EXPECT_EQ((*link("lan"))["state"], "up");
    call("link.remove", {{"link", "lan"}});
  }
}

TEST_F(RunTimeLinks, NothingOfALinkThatIsGoneIsToldOfTheNext) {
  UdpPeer station;
  call("subscribe", {{"topic", "links"}});
  std::string topic;
  json told;
  const auto hears_of = [&](const std::string& name) {
    while (casd_->client().next_notification(topic, told, kPatience)) {
      if (told["link"] == name) return true;
    }
    return false;
  };
  call("link.add", {{"entry", entry_to(station)}});
  EXPECT_TRUE(hears_of("gcs"));
  station.set_remote(port("gcs"));
  mav::Encoder from_station{{255, 190}};
  PacketStream at_vehicle;
  ASSERT_TRUE(wait_until([&] {
    station.send(from_station(mavlink::common::SystemTime{}));
    vehicle_.read(at_vehicle);
    return at_vehicle.count(mavlink::common::SystemTime::kId) > 0;
  }));
  const auto routes = [&]() -> std::size_t {
    for (const json& each : call("link.latency")) {
      if (each["link"] == "fcu") return each["routes"].size();
    }
    return 0;
  };
  EXPECT_TRUE(wait_until([&] { return routes() == 1; })) << "timed after it was written";
  call("link.remove", {{"link", "gcs"}});
  EXPECT_EQ(routes(), 0U);
  UdpPeer other;
  call("link.add", {{"entry", {{"endpoint", "udp:" + other.endpoint()}}}});
  EXPECT_EQ(routes(), 0U) << "it has the number of the other";
  EXPECT_TRUE(hears_of("udp"));
  call("link.add", {{"entry", entry_to(station)}});
  EXPECT_TRUE(hears_of("gcs")) << "it came up once more";
}

TEST_F(RunTimeLinks, TheOnlyLinkOfAnArmedVehicleIsRemovedByForceAlone) {
  UdpPeer station;
  call("link.add", {{"entry", entry_to(station)}});
  meet_vehicle(true);
  EXPECT_THAT(casd_->refusal("link.remove", {{"link", "fcu"}}), HasSubstr("vehicle 1 is armed"));
  call("link.remove", {{"link", "gcs"}});
  call("link.add", {{"entry", entry_to(station)}});
  EXPECT_EQ(call("link.remove", {{"link", "fcu"}, {"force", true}})["link"], "fcu");
  EXPECT_EQ(call("link.list").size(), 1U);
}

TEST_F(RunTimeLinks, TheLinkOfAnArmedVehiclesSimulatorIsRemovedByForceAlone) {
  UdpPeer simulator;
  json entry = entry_to(simulator);
  entry["name"] = "sim";
  entry["accept"] = "everything";
  call("link.add", {{"entry", entry}, {"routes", json::array({{{"from", "sim"}, {"to", "fcu"}}})}});
  simulator.set_remote(port("sim"));
  meet_vehicle(true);
  mav::Encoder from_simulator{{1, 200}};
  ASSERT_TRUE(wait_until([&] {
    simulator.send(from_simulator(HilSensor{}));
    return std::ranges::any_of(call("message.list"), [](const json& each) {
      return each["link"] == "fcu" && each["direction"] == "tx" && each["name"] == "HIL_SENSOR";
    });
  }));
  EXPECT_THAT(casd_->refusal("link.remove", {{"link", "sim"}}),
              HasSubstr("flies on HIL_SENSOR of link 'sim'"));
  EXPECT_EQ(call("link.remove", {{"link", "sim"}, {"force", true}})["link"], "sim");
}

TEST_F(RunTimeLinks, DoctorAsksNoVehicleForHilThatCasdOnlyRoutesFor) {
  UdpPeer station;
  call("link.add",
       {{"entry", entry_to(station)},
        {"routes",
         json::array({{{"from", "gcs"}, {"to", "fcu"}, {"block", json::array({"HIL_SENSOR"})}}})}});
  Heartbeat real = heartbeat(false);
  real.autopilot = mavlink::common::MavAutopilot::kArdupilotmega;
  real.base_mode = MavModeFlag::kCustomModeEnabled;
  real.system_status = mavlink::common::MavState::kStandby;
  vehicle_.send(from_vehicle_(real));
  ASSERT_TRUE(wait_until([&] { return call("casd.status")["vehicles"].size() == 1; }));
  // Not ready to fly, but with no advice to send it sensor data.
  const std::string said = casctl({"doctor", "--seconds", "0.1"}, 1);
  EXPECT_THAT(said, HasSubstr("casd only routes for it"));
  EXPECT_THAT(said, HasSubstr("Nothing wrong was found"));
  EXPECT_THAT(said, Not(HasSubstr("start hilsim")));
}

TEST_F(RunTimeLinks, CasctlAddsAndRemovesThem) {
  UdpPeer station;
  EXPECT_THAT(casctl({"link", "add", "udp:" + station.endpoint()}),
              HasSubstr("link udp added, up"));
  EXPECT_THAT(casctl({"links"}),
              HasSubstr("added at run time, ended by a reload of a topology without it: udp"));
  casctl({"link", "add", "{name: tap, type: udp_server, local: 127.0.0.1:0, sniffer: true}"});
  EXPECT_THAT(casctl({"links"}), HasSubstr("sniffer, gets every packet and takes in nothing: tap"));
  casctl({"link", "remove", "tap"});
  const std::string entry = "{name: lan, type: udp_server, local: 127.0.0.1:0, max_peers: 3}";
  const std::string added = casctl({"link", "add", entry, "--accept", "everything", "--routes",
                                    "[{from: fcu, to: lan, block: [HIL_SENSOR, 300]}]"});
  EXPECT_THAT(added, HasSubstr("link lan added, up"));
  const json routes = call("link.routes");
  const bool blocks = std::ranges::any_of(routes, [](const json& route) {
    return route["to"] == "lan" && route.contains("block") && route["block"].size() == 2;
  });
  EXPECT_TRUE(blocks) << routes.dump();
  EXPECT_THAT(casctl({"link", "remove", "lan"}), HasSubstr("link lan removed"));
  EXPECT_FALSE(link("lan"));
  EXPECT_THAT(casctl({"link", "add", "tcp:"}, 1), HasSubstr("has no port"));
  EXPECT_THAT(casctl({"link", "remove", "lan"}, 1), HasSubstr("there is no link 'lan'"));
}

}  // namespace
}  // namespace cas::test
